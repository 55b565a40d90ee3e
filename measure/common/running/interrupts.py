"""Ctrl-C ends a command with one sentence at any time: while it is being loaded, at work, and when its results stand.

The module that every command loads first; it loads little itself.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from types import FrameType
from typing import Any, NoReturn

COMMANDS = (
    *("unspool", "track-video", "fit-actuator", "simulate-deployment", "sweep-deployments"),
    *("design-control", "design-deployment", "compare-model", "explain-gap"),
)
STOPPED, ENDED_FROM_OUTSIDE = 130, 143
_AGAIN_S = 0.02
_OURS = ("measure", "simulate", "identify")
_LONGEST_IMPORT_S = 10.0


class Terminated(KeyboardInterrupt):
    """The system asked the process to end; it tidies up as for Ctrl-C."""


def watch_while_loading() -> None:
    """Answer Ctrl-C until `Interruptible` takes over; only in a process that was started as one of the commands."""
    if _name() in COMMANDS and _is_main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _stopped_while_loading)


class Interruptible:
    """Within the block Ctrl-C is a KeyboardInterrupt and SIGTERM a `Terminated`; a command that has ended is stopped by neither.

    A library that is being imported turns the exception into one of its own or loses it: it waits until the import has ended. One that
    was lost in a callback is raised again.
    """

    def __enter__(self) -> None:
        self.active = _is_main_thread() and signal.getsignal(signal.SIGTERM) not in (None, self._asked)
        if not self.active:
            return
        self.kind: type[KeyboardInterrupt] = KeyboardInterrupt
        self.since = 0.0
        self.owned = signal.getsignal(signal.SIGINT) is _stopped_while_loading
        takes_int = self.owned or signal.getsignal(signal.SIGINT) is signal.default_int_handler
        self.before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)}
        self.unraisable, sys.unraisablehook = sys.unraisablehook, self._lost
        signal.signal(signal.SIGTERM, self._asked)
        signal.signal(signal.SIGALRM, self._asked_again)
        if takes_int:
            signal.signal(signal.SIGINT, self._asked)

    def __exit__(self, *_: Any) -> None:
        if not self.active:
            return
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if not (self.owned and self.since):  # what is left half made complains when it goes
            sys.unraisablehook = self.unraisable
        for number, handler in self.before.items():
            signal.signal(number, signal.SIG_IGN if self.owned and number != signal.SIGALRM else handler)

    def _asked(self, number: int, frame: FrameType | None) -> None:
        self.kind, self.since = (Terminated if number == signal.SIGTERM else KeyboardInterrupt), time.monotonic()
        self._asked_again(number, frame)

    def _asked_again(self, number: int, frame: FrameType | None) -> None:
        del number
        if _is_importing(frame) and time.monotonic() - self.since < _LONGEST_IMPORT_S:
            signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
            return
        raise self.kind

    def _lost(self, what: Any) -> None:
        if issubclass(what.exc_type, KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
        elif not self.since:
            self.unraisable(what)


def _is_importing(frame: FrameType | None) -> bool:
    """Whether the machinery of imports is at work on somebody else's module; our own may be left half loaded."""
    loaded = ""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib") and loaded not in _OURS:
            return True
        loaded = str(frame.f_globals.get("__name__")).partition(".")[0] if frame.f_code.co_name == "<module>" else loaded
        frame = frame.f_back
    return False


def _name() -> str:
    return os.path.splitext(os.path.basename(sys.argv[0]))[0] if sys.argv else ""


def _is_main_thread() -> bool:
    import threading

    return threading.current_thread() is threading.main_thread()


def _stopped_while_loading(number: int, frame: FrameType | None) -> NoReturn:
    del number, frame
    os.write(2, f"{_name()}: stopped; nothing was written\n".encode())
    os._exit(STOPPED)
