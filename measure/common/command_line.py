"""What every command shares: its options, the way it reports progress, and the way it ends."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NoReturn, TypeVar

from measure.common.errors import InputError, nearest
from measure.common.version import ShowVersion

DONE, VERDICT_BAD, UNUSABLE = 0, 1, 2

# The matrices here are tall and small: threads of the linear algebra win nothing, fight with those of the kernels, and
# would let the last digits depend on the number of cores. It must be said before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

T = TypeVar("T")


class Parser(argparse.ArgumentParser):
    """An option parser that speaks like the rest of the program: one sentence, status 2, nearest option named."""

    def error(self, message: str) -> NoReturn:
        """Turn argparse's complaint into ours."""
        raise InputError(self._advised(message))

    def _advised(self, message: str) -> str:
        prefix = "unrecognized arguments: "
        if message.startswith(prefix):
            word = message.removeprefix(prefix).split()[0]
            options = [name for action in self._actions for name in action.option_strings]
            return f'unknown option "{word}"; {nearest(word, options)}'
        return f"{message}. See {self.prog} --help."


def parser(name: str, does: str, *, output: str, output_default: str | None = None) -> Parser:
    """A parser with the options that all commands have in common.

    Parameters
    ----------
    name, does : the command and what it does, in a sentence.
    output : what `--output` is, for the help text.
    """
    made = Parser(prog=name, description=does, allow_abbrev=False)
    made.add_argument("-o", "--output", type=Path, metavar="PATH", default=output_default and Path(output_default), help=output)
    made.add_argument("--json", type=Path, metavar="FILE", help="write the result as JSON")
    made.add_argument("--quiet", action="store_true", help="print nothing but errors, show no progress")
    made.add_argument("--version", action=ShowVersion, help="print the version and end")
    return made


_STATUS = "exit status: 0 done; 1 done, with a bad verdict; 2 unusable input, nothing written; 70 a fault of the program"


def examples(made: Parser, *lines: str, guide: str = "") -> Parser:
    """The parser with examples, the exit status and the page of the guide at the end of its help.

    Parameters
    ----------
    lines : commands as they are typed.
    guide : name of the page below docs/how-to; by default that of the command.
    """
    shown = "\n".join(f"  {line}" for line in lines)
    page = f"docs/how-to/{guide or made.prog.split()[0]}.md"
    made.epilog = f"examples:\n{shown}\n\n{_STATUS}\nmore: {page} of the documentation"
    made.formatter_class = argparse.RawDescriptionHelpFormatter
    return made


def run(name: str, work: Callable[[Sequence[str]], int], arguments: Sequence[str] | None = None) -> int:
    """Call a command's work; unusable input becomes one message on standard error and status 2, a fault of the program a file and 70."""
    try:
        return _flushed(work(sys.argv[1:] if arguments is None else arguments))
    except InputError as error:
        print(f"{name}: error: {error}", file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        print(f"{name}: stopped; nothing was written", file=sys.stderr)
        return 130
    except BrokenPipeError:
        return _unheard(DONE)
    except OSError as error:
        print(f"{name}: error: {_refusal(error)}", file=sys.stderr)
        return UNUSABLE
    except Exception as error:
        from measure.common.fault import FAULT, sentence_of

        print(sentence_of(name, sys.argv[1:] if arguments is None else arguments, error), file=sys.stderr)
        return FAULT


def _flushed(status: int) -> int:
    """The status, once everything said has gone out; a reader who has left, as `head` does, changes nothing of it."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        return _unheard(status)
    return status


def _unheard(status: int) -> int:
    """The status; what would still be printed goes nowhere, so that Python does not complain of the closed pipe at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())  # type: ignore[union-attr]
    return status


def _refusal(error: OSError) -> str:
    """What the system refused, as a sentence: no permission, a full disk, a folder where a file was expected."""
    if error.filename is None:
        return f"{error.strerror or error}."
    return f"{error.filename}: {error.strerror}. Check that it is there and that you may use it."


def progress(items: Iterable[T], *, what: str, total: int | None = None, quiet: bool = False) -> Iterator[T]:
    """The same items, with a bar on standard error while they are worked through.

    Commands wrap what they loop over or hand the bar's `update` to a kernel's caller; kernels know nothing of it.
    """
    from tqdm import tqdm

    return iter(tqdm(items, desc=what, total=total, disable=quiet or not sys.stderr.isatty(), leave=False))


def existing_file(path: Path, *, what: str) -> Path:
    """`path` itself, if it is a file; else the sentence that says what was looked for.

    Raises
    ------
    InputError
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder, and {what} was expected. Name the file in it.")
    if not path.is_file():
        siblings = sorted(p.name for p in path.parent.iterdir()) if path.parent.is_dir() else []
        hint = nearest(path.name, siblings) if siblings else "Check the name."
        hint = hint if hint.startswith("did you mean") else "Check the name."
        raise InputError(f"{path}: no such file; {what} was expected. {hint[0].upper()}{hint[1:]}")
    return path
