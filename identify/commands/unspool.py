"""`unspool`: where one begins; each task of it is a file in `subcommands`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module

from identify.commands.subcommands.tasks import TASKS
from measure.common.command_line import DONE, Parser, run
from measure.common.errors import InputError, nearest
from measure.common.version import ShowVersion

NAME = "unspool"
_COMMANDS = """commands beside this one:
  track-video            a film becomes the trajectory of the platform
  fit-actuator           loops become the force law of a leg
  simulate-deployment    a model becomes one deployment
  sweep-deployments      a model becomes thousands of them, and tolerances
  design-control         a model gets a controller, with a certificate
  design-deployment      values of a model, or tolerances, chosen by optimisation
  compare-model          a model against measurements, in numbers
  explain-gap            which effect the model lacks

examples:
  unspool init rig --like demo
  unspool check rig/*.toml

Tasks that write take -o/--output, --json and --quiet; all take --help. Exit status: 0 done; 1 done with a bad verdict; 2 unusable input,
nothing written; 70 a fault of the program."""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command: the task named by the first word does the rest."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in TASKS:
        return import_module(f"identify.commands.subcommands.{words[0]}").main(words[1:])
    return run(NAME, _work, words)


def _work(arguments: Sequence[str]) -> int:
    made = _parser()
    given, _ = made.parse_known_args(arguments)
    if given.task is not None:
        raise InputError(f'unspool has no task "{given.task}"; {nearest(given.task, TASKS)}')
    made.parse_args(arguments)
    made.print_help()
    return DONE


def _parser() -> Parser:
    tasks = "tasks:\n" + "\n".join(f"  {name:<12}{does}" for name, does in TASKS.items())
    what = "Identify, simulate and explain self-deploying tape-spring hexapods."
    made = Parser(
        prog=NAME,
        usage="unspool TASK ... (unspool TASK --help says more)",
        description=f"{what}\n\n{tasks}",
        epilog=_COMMANDS,
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("task", nargs="?", metavar="TASK", help=argparse.SUPPRESS)
    made.add_argument("--version", action=ShowVersion, help="print the version and end")
    return made


if __name__ == "__main__":
    sys.exit(main())
