"""The bench board of explain-gap: `python tests/hidden/bench.py --seed N --share 0.25`.

At most 120 cases as a laboratory has them (coloured noise, a model file within its tolerances or beyond, forces from run to run, effects,
forces that no catalogue holds). Makes those that are not there yet, asks about each, breaks the seals, and writes `bench.json` and
`bench.md` beside the answers. What has been answered by the same sources is not asked again.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from benchtop.cases import board
from benchtop.making import made
from benchtop.page import as_json, markdown, printed
from benchtop.scoring import scored
from board.running import OURS, PATIENCE_S, ask_all, read_answers, version

from measure.common.output import json_text, write_text


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True, help="from which the cases are drawn")
    parser.add_argument("--share", type=float, default=1.0, help="of each kind, default all 120 cases")
    parser.add_argument("--cases", type=int, metavar="N", help="only the first N, which are a fair sample")
    parser.add_argument("--answered", action="store_true", help="ask nothing: score what the present sources have answered")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--patience", type=float, default=PATIENCE_S, metavar="S", help="processor time after which a case has failed")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/bench"), metavar="FOLDER")
    return parser


def main(arguments: list[str] | None = None) -> int:
    given = _parser().parse_args(arguments)
    specs = board(given.seed, given.share)[: given.cases]
    file = given.output / f"{OURS}.jsonl"
    if given.answered:
        have = {answer.token: answer for answer in read_answers(file) if answer.version == version()}
        specs = [spec for spec in specs if spec.token in have]
    else:
        makers = {spec.token: partial(made, spec, given.output) for spec in specs}
        have = ask_all(makers, OURS, file, processes=given.processes, patience_s=given.patience, say=partial(print, file=sys.stderr))
    rows = scored(specs, [have[spec.token] for spec in specs], given.output)
    about = f"Seed {given.seed}, share {given.share:g}, {len(rows)} cases, sources `{version()}`."
    print(printed(rows))
    write_text(given.output / "bench.json", json_text(as_json(rows)))
    write_text(given.output / "bench.md", markdown(rows, about))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
