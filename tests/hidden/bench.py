"""The bench board of explain-gap: `python tests/hidden/bench.py --seed N --share 0.25`.

At most 120 cases as a laboratory has them (coloured noise, a model file within its tolerances or beyond, forces from run to run, effects,
forces that no catalogue holds). Makes those that are not there yet, asks about each, breaks the seals, and writes `bench.json` and
`bench.md` beside the answers. What has been answered by the same sources is not asked again.
"""

from __future__ import annotations

import argparse
import sys
from datetime import date
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from benchtop.asking import MINUTES, PATIENCE_S, answered, ask
from benchtop.cases import board
from benchtop.page import as_json, markdown, printed
from board.running import version

from measure.common.output import json_text, write_text


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True, help="from which the cases are drawn")
    parser.add_argument("--share", type=float, default=1.0, help="of each kind, default all 120 cases")
    parser.add_argument("--cases", type=int, metavar="N", help="only the first N, which are a fair sample")
    parser.add_argument("--answered", action="store_true", help="ask nothing: score what the present sources have answered")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--patience", type=float, default=PATIENCE_S, metavar="S", help="processor time after which a case has failed")
    parser.add_argument("--minutes", type=float, default=MINUTES, metavar="M", help="no case is begun after so long; default %(default)s")
    parser.add_argument("--page", type=Path, metavar="FILE", help="where the page is written, default bench.md beside the answers")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/bench"), metavar="FOLDER")
    return parser


def main(arguments: list[str] | None = None) -> int:
    given = _parser().parse_args(arguments)
    drawn = board(given.seed, given.share)[: given.cases]
    how = {"processes": given.processes, "patience_s": given.patience, "minutes": given.minutes, "say": partial(print, file=sys.stderr)}
    rows = answered(drawn, given.output) if given.answered else ask(drawn, given.output, **how)
    about = f"{date.today()}: seed {given.seed}, share {given.share:g}, {len(rows)} of {len(drawn)} cases answered, sources `{version()}`."
    print(printed(rows))
    write_text(given.output / "bench.json", json_text(as_json(rows)))
    write_text(given.page or given.output / "bench.md", markdown(rows, about))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
