"""How much processor time each test takes, whatever else the machine does; reported at the end, and held to limits on request.

Counted are this process and the children it has waited for. What is shared is not a test's own: fixtures that serve more than
one test, and the compilation of kernels, which happens once in a clone. `--time-limits` measures tests beyond their limit once
more, alone and warm, and counts them in seconds of a quiet machine: what a fixed sum takes before and after a test says how
much slower this machine is just then. Only what takes twice the limit even so makes the run fail.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

PLAIN_S, SLOW_S = 5.0, 60.0  # processor time of a test without a mark, and of one marked slow
AGAIN = 2.0  # memory and caches that are shared with others slow a test down more than the fixed sum
TERMS, QUIET_S = 1_000_000, 0.07  # the fixed sum, and its processor time on a machine that counts as quiet


def spent_s() -> float:
    """Processor time of this process and of its ended children."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def pace() -> float:
    """How many times slower than a quiet machine this one is now; 1 where it is faster."""
    began = time.process_time()
    sum(number * number % 7 for number in range(TERMS))
    return max(1.0, (time.process_time() - began) / QUIET_S)


class Compilation:
    """How much processor time numba's compilations have taken so far, from when it is listened to."""

    def __init__(self) -> None:
        self.seconds, self._depth, self._began = 0.0, 0, 0.0

    def begins(self) -> None:
        self._began = self._began if self._depth else spent_s()
        self._depth += 1

    def ends(self) -> None:
        self._depth -= 1
        self.seconds += 0.0 if self._depth else spent_s() - self._began

    def listen(self) -> None:
        from numba.core import event

        whole = self

        class Listener(event.Listener):
            def on_start(self, event: object) -> None:
                whole.begins()

            def on_end(self, event: object) -> None:
                whole.ends()

        event.register("numba:compile", Listener())


@dataclass
class Clock:
    """Processor time of the present test, and how much of it others share."""

    compiling: Compilation = field(default_factory=Compilation)
    listening: bool = False
    began: float = 0.0
    shared: float = 0.0
    fixtures: list[tuple[str, float]] = field(default_factory=list)

    def own(self) -> float:
        """Spent so far, without compilation."""
        return spent_s() - self.compiling.seconds

    def start(self) -> None:
        """Begin with a test; a library that nobody has imported yet is not imported for this."""
        if not self.listening and "numba" in sys.modules:
            self.compiling.listen()
            self.listening = True
        self.began, self.shared, self.fixtures = self.own(), 0.0, []


class Measuring:
    """In each test process: measures, and sends the figures along with the reports; in seconds of a quiet machine if asked for."""

    def __init__(self, quiet: bool) -> None:
        self.clock, self.quiet, self.pace = Clock(), quiet, 1.0

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.pace = pace() if self.quiet else 1.0
        self.clock.start()
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any, request: pytest.FixtureRequest) -> Iterator[None]:
        if fixturedef.scope == "function":
            return (yield)
        began, others = self.clock.own(), self.clock.shared
        try:
            return (yield)
        finally:
            took = self.clock.own() - began - (self.clock.shared - others)
            self.clock.shared += took
            self.clock.fixtures.append((f"{fixturedef.baseid}::{fixturedef.argname}", took))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Any:
        report = yield
        if report.when == "teardown":
            took = self.clock.own() - self.clock.began - self.clock.shared
            slower = 0.5 * (self.pace + pace()) if self.quiet else 1.0
            report.user_properties.append(("processor_s", took / slower))
            report.user_properties += [("shared_s", list(fixture)) for fixture in self.clock.fixtures]
        return report


@dataclass(frozen=True)
class Took:
    """One test: its processor time, and the most it may take."""

    test: str
    seconds: float
    limit: float


class Reporting:
    """In the process that the user started: collects the figures, prints them and holds them to the limits."""

    def __init__(self, config: pytest.Config) -> None:
        self.config, self.took = config, list[Took]()
        self.shared: dict[str, float] = {}
        self.verdict: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, value in report.user_properties if report.when == "teardown" else ():
            if name == "processor_s":
                limit = float("inf") if "calibrate" in report.keywords else SLOW_S if "slow" in report.keywords else PLAIN_S
                self.took.append(Took(report.nodeid.split("@")[0], float(value), limit))  # type: ignore[arg-type]
            elif name == "shared_s":
                fixture, seconds = value  # type: ignore[misc]
                self.shared[fixture] = self.shared.get(fixture, 0.0) + seconds

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        file = self.config.getoption("--processor-times")
        if file:
            found = {"tests": {one.test: one.seconds for one in self.took}, "shared": self.shared}
            Path(file).write_text(json.dumps(found, indent=1), encoding="utf-8")
        ended = session.exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
        if not (ended and self.config.getoption("--time-limits")):
            return
        over = {one.test: one for one in self.took if one.seconds > one.limit}
        still = [one for one in self._again(list(over)) if one.seconds > AGAIN * one.limit]
        says = "{0.test} takes {0.seconds:.1f} s of a quiet processor's time, alone too; at most {0.limit:g} s."
        self.verdict = [says.format(one) for one in still]
        if self.verdict and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _again(self, tests: list[str]) -> list[Took]:
        if not tests:
            return []
        limits = {one.test: one.limit for one in self.took}
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "times.json"
            options = ["-q", "-p", "no:xdist", "--quiet-seconds", "--processor-times", file]
            command = [Path(sys.executable).with_name("pytest"), *options, *tests]
            subprocess.run(command, cwd=self.config.rootpath, capture_output=True, check=False)
            measured = json.loads(file.read_text(encoding="utf-8"))["tests"] if file.exists() else {}
        return [Took(test, seconds, limits[test]) for test, seconds in measured.items() if test in limits]

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        over = sorted((one for one in self.took if one.seconds > one.limit), key=lambda one: -one.seconds)
        total, shared = sum(one.seconds for one in self.took), sum(self.shared.values())
        slow = [one.seconds for one in self.took if one.limit == SLOW_S]
        say = terminalreporter.write_line
        say(f"processor time: {total:.0f} s of {len(self.took)} tests ({sum(slow):.0f} s of {len(slow)} slow), {shared:.0f} s shared")
        for one in over:
            say(f"  {one.seconds:6.1f} s, limit {one.limit:g} s  {one.test}")
        for sentence in self.verdict:
            say(sentence, red=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("processor time")
    group.addoption("--processor-times", metavar="FILE", help="write the processor time of each test to FILE (JSON)")
    group.addoption("--quiet-seconds", action="store_true", help="count processor time in seconds of a quiet machine")
    group.addoption("--time-limits", action="store_true", help="fail if a test takes too much processor time, measured twice")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Measuring(bool(config.getoption("--quiet-seconds"))), "measuring-processor-time")
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Reporting(config), "reporting-processor-time")


def _group(item: pytest.Item) -> str | None:
    """Tests of one group run in one process: those that share a fixture of their module, or one that is dear."""
    names = getattr(item, "fixturenames", ())
    dear = {"shaken", "commands"} & set(names)
    if dear:
        return dear.pop()
    shared = getattr(item, "_fixtureinfo", None)
    defs = [found[-1] for found in shared.name2fixturedefs.values()] if shared else []
    of_module = any(found.scope == "module" and found.baseid.endswith(".py") for found in defs)
    return item.nodeid.partition("::")[0] if of_module or "fitted" in names else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Long tests first, so that no process ends with one; what shares a fixture stays in one process."""
    for item in items if config.pluginmanager.hasplugin("xdist") else ():
        group = _group(item)
        if group and not item.get_closest_marker("xdist_group"):
            item.add_marker(pytest.mark.xdist_group(group))
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
