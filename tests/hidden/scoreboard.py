"""The public scoreboard of explain-gap: `python tests/hidden/scoreboard.py --subset fast|standard|full|seed-N,M`.

Makes the cases that are not there yet, asks each method about each of them, breaks the seals, and writes `scoreboard.json` and
`scoreboard.md` beside the answers. What has been answered by the same sources is not asked again.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from board.further import splits
from board.page import markdown, printed
from board.running import METHODS, OURS, PATIENCE_S, run, tokens_answered, version
from board.scoring import scored
from board.specs import board, chosen
from board.tally import tally

from measure.common.output import json_text, write_text


def _parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    subsets = "fast, standard (seed 0), full (seeds 0 to 3), or seed-N,M: these seeds, which may be ones that nobody was asked about"
    made.add_argument("--subset", type=_subset, default="standard", metavar="NAME", help=subsets)
    made.add_argument("--cases", type=int, metavar="N", help="only the first N of the board, which is in a random order")
    made.add_argument("--skip", type=int, default=0, metavar="N", help="leave out the first N, of which an earlier run may have told")
    only = (
        "only cases that hide this effect, or 'nothing', 'outside' or 'several', or of this run set, noise or engine, "
        "or '3x', 'own-tare' or 'seed-1'; all words have to fit"
    )
    made.add_argument("--only", metavar="WORD", action="append", default=[], help=only)
    made.add_argument("--answered", action="store_true", help="only cases that the same sources have answered")
    made.add_argument("--method", action="append", choices=tuple(METHODS), help=f"repeatable; default {OURS}")
    made.add_argument("--processes", type=int, default=2)
    made.add_argument("--patience", type=float, default=PATIENCE_S, metavar="S", help="processor time after which a case has failed")
    made.add_argument("--further", action="store_true", help="do the test that is recommended for each class, and ask again")
    made.add_argument("-o", "--output", type=Path, default=Path("out/hidden"), metavar="FOLDER")
    return made


def _subset(text: str) -> str:
    if text in ("fast", "standard", "full") or (
        text.startswith("seed-") and all(number.isdecimal() for number in text.removeprefix("seed-").split(","))
    ):
        return text
    raise argparse.ArgumentTypeError(f"{text!r} is none of fast, standard, full, seed-N and seed-N,M")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def main(arguments: list[str] | None = None) -> int:
    made = _parser()
    given = made.parse_args(arguments)
    methods = given.method or [OURS]
    specs = chosen(board(given.subset), given.only, given.cases, given.skip)
    if given.answered:
        specs = [spec for spec in specs if all(spec.token in tokens_answered(method, given.output) for method in methods)]
    if not specs:
        made.error(f"no case of the {given.subset} board fits {' and '.join(given.only) or 'what is left'}")
    found: dict[str, Any] = {}
    for method in methods:
        how = {"processes": given.processes, "patience_s": given.patience, "say": _say}
        answers = run(specs, method, given.output, **how)
        rows = scored(specs, answers, given.output)
        done = splits(rows, answers, method, given.output, **how) if given.further else []
        found[method] = tally(rows, done)
        print(printed(method, rows, done))
    write_text(given.output / "scoreboard.json", json_text({"subset": given.subset, "sources": version(), "methods": found}))
    write_text(given.output / "scoreboard.md", markdown(found, given.subset, version()))
    print(f"scoreboard  {given.output / 'scoreboard.md'}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
