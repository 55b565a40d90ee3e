"""What every command shares: its options, the way it reports progress, and the way it ends."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from measure.common.errors import InputError, OptionsMissing, nearest, visible
from measure.common.running.interrupts import ENDED_FROM_OUTSIDE, STOPPED, Interruptible, Terminated
from measure.common.version import ShowVersion

DONE, VERDICT_BAD, UNUSABLE = 0, 1, 2
_MOST_THREADS = 4096

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
    made.formatter_class = _Help
    return made


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help that keeps the lines of the examples and gives the default of every option that has one."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        said = action.help
        if not said or "default" in said or action.default in (None, False, "", [], argparse.SUPPRESS) or "%" in str(action.default):
            return said
        return f"{said}; default: %(default)s"


def next_command(*words: object) -> str:
    """The line that ends a command's output: what one would type next, ready to be copied.

    Parameters
    ----------
    words : of the command; a word in capitals stands for something of the user's.
    """
    return "next     " + shlex.join(str(word) for word in words)


def run(name: str, work: Callable[[Sequence[str]], int], arguments: Sequence[str] | None = None) -> int:
    """Call a command's work; unusable input becomes one message on standard error and status 2, a fault of the program a file and 70."""
    before = _appearances()
    with Interruptible():
        try:
            return _ended(name, work, arguments)
        except Terminated as end:
            complain(f"{name}: ended from outside; {_what_stands(end, before)}")
            return ENDED_FROM_OUTSIDE
        except KeyboardInterrupt as stop:
            complain(f"{name}: stopped; {_what_stands(stop, before)}")
            return STOPPED


def _ended(name: str, work: Callable[[Sequence[str]], int], arguments: Sequence[str] | None) -> int:
    """The status of a command that nobody stops."""
    _occupy_standard_streams()
    words = sys.argv[1:] if arguments is None else arguments
    try:
        _settle_environment()
        return _flushed(work(words))
    except InputError as error:
        complain(f"{name}: error: {error}{_whole_line(name, words, error)}")
        return UNUSABLE
    except MemoryError:
        complain(f"{name}: error: there is not enough memory for this. Cut the input, or ask for less.")
        return UNUSABLE
    except BrokenPipeError:
        return _unheard(DONE)
    except OSError as error:
        complain(f"{name}: error: {_refusal(error)}")
        return UNUSABLE
    except Exception as error:
        from measure.common.fault import FAULT, sentence_of

        complain(sentence_of(name, words, error))
        return FAULT


def _whole_line(name: str, words: Sequence[str], error: InputError) -> str:
    """The command with the options that it lacks, ready to be copied; nothing where a part of them only the user knows."""
    if not isinstance(error, OptionsMissing) or _TO_FILL_IN.search(error.options):
        return ""
    return f"\nThe whole line: {shlex.join([name, *words])} {error.options}"


_TO_FILL_IN = re.compile(r"(?:=| )(NAME|UNIT|SECONDS)(?: |$)")


def _settle_environment() -> None:
    """What libraries would stumble over before anybody can say so.

    Raises
    ------
    InputError
        A number of threads that is none.
    """
    os.environ["MPLBACKEND"] = "Agg"  # figures go to files; a backend that is not there would end the run
    os.environ.pop("NUMBA_DISABLE_JIT", None)  # the kernels are addresses of compiled code, there is nothing to fall back on
    threads = os.environ.get("NUMBA_NUM_THREADS", "1")
    if not (threads.isascii() and threads.isdigit() and 0 < int(threads[:9]) <= _MOST_THREADS):
        raise InputError(f'NUMBA_NUM_THREADS is "{threads}": give a number of threads from 1 to {_MOST_THREADS}, or unset it.')


def _occupy_standard_streams() -> None:
    """Where a standard stream is closed, the next file that is opened would take its place and get what is printed."""
    while (handle := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(handle)


def _what_stands(stop: KeyboardInterrupt, before: int) -> str:
    """Of a run that was stopped: what it has noted, or that it had come to its end before it was."""
    if _appearances() > before:
        return "the results had been written, whole"
    return "; ".join(getattr(stop, "__notes__", ())) or "nothing was written"


def _appearances() -> int:
    """How often results have appeared; none have while nothing that writes is loaded."""
    output = sys.modules.get("measure.common.output")
    return output.appearances() if output else 0


def say(*lines: str) -> None:
    """Print for people; what a name carries for the terminal is shown escaped. Nobody need listen: results do not depend on it."""
    if sys.stdout is None:
        return
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    text = visible("\n".join(lines)).encode(encoding, "backslashreplace").decode(encoding)
    try:
        print(text, flush=True)
    except OSError as error:
        _lost(error)


def complain(text: str) -> None:
    """Print on standard error, where there is one."""
    if sys.stderr is None:
        return
    try:
        print(visible(text), file=sys.stderr, flush=True)
    except OSError:
        _silence(sys.__stderr__)


def _flushed(status: int) -> int:
    """The status, once everything said has gone out; a reader who has left, as `head` does, changes nothing of it."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        _lost(error)
    return status


def _lost(error: OSError) -> None:
    """Say that standard output takes nothing more, unless its reader has left as `head` does."""
    if not isinstance(error, BrokenPipeError):
        complain(f"standard output takes nothing ({error.strerror}); the results are not touched by that")
    _unheard(DONE)


def _unheard(status: int) -> int:
    """The status; what would still be printed goes nowhere, so that Python does not complain of the closed pipe at its end."""
    _silence(sys.__stdout__)
    return status


def _silence(stream: Any) -> None:
    with suppress(OSError, ValueError, AttributeError):  # it may be no file
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _refusal(error: OSError) -> str:
    """What the system refused, as a sentence: no permission, a full disk, a folder where a file was expected."""
    if error.filename is None:
        return f"{error.strerror or error}."
    return f"{error.filename}: {error.strerror}. Check that it is there and that you may use it."


def watched() -> bool:
    """Whether somebody looks at standard error."""
    return sys.stderr is not None and sys.stderr.isatty()


def foretell(name: str, quiet: bool, change: str = "") -> Callable[[float], None]:
    """What says on standard error how long the work ahead will take, given its seconds.

    change : what to give instead where that is too long.

    Raises
    ------
    InputError
        When it is told of more than anybody waits for.
    """
    from measure.common.running.duration import in_words, require_endable

    def say_so(seconds: float) -> None:
        require_endable(seconds, change)
        if not quiet:
            complain(f"{name}: this takes {in_words(seconds)}")

    return say_so


def progress(items: Iterable[T], *, what: str, total: int | None = None, quiet: bool = False, change: str = "") -> Iterator[T]:
    """The same items, with a bar on standard error while they are worked through, or where nobody looks how long the rest takes.

    Commands wrap what they loop over or hand the bar's `update` to a kernel's caller; kernels know nothing of it. `change`, where the
    items are alike in cost, says what to give instead if they take longer than anybody waits; else nothing is foretold.
    """
    from tqdm import tqdm

    from measure.common.running.duration import foretold

    timed = foretold(items, total, foretell(what, quiet or watched(), change)) if total and change else items
    return iter(tqdm(timed, desc=what, total=total, disable=quiet or not watched(), leave=False))
