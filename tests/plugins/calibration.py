"""`make calibrate`: the statistical suites, with a fresh seed, and the tables that they leave under docs/validation/calibration.

A test marked `calibrate` runs only where it is asked for (`--calibrate`, `-m calibrate`, or by its full name). It takes its
chance from `calibration_seed`. A test that repeats something asks `share_of(200)` how often, so that `--share 0.1` makes a tenth of
it; of the tests that do not, `--share` draws as many by the seed. What a test has measured it hands to `validation_table`; the
tables of one test module make one page.
"""

from __future__ import annotations

import random
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

Rows = Sequence[Mapping[str, Any]]
USUAL_SEED = 2009
SURE = 0.005  # how often a rate at the end of its range may be called outside of it


def consistent(hits: int, cases: int, low: float, high: float = 1.0) -> bool:
    """Whether a true rate between low and high gives so many hits, but for one time in two hundred at its ends."""
    from scipy.stats import binom

    return bool(binom.cdf(hits, cases, low) > SURE and binom.sf(hits - 1, cases, high) > SURE)


def share(hits: int, cases: int) -> str:
    """A share in per cent with its 95 % interval (Clopper and Pearson 1934), for a table."""
    from scipy.stats import binomtest

    if not cases:
        return "none"
    found = binomtest(hits, cases).proportion_ci(0.95, method="exact")
    return f"{100 * hits / cases:.1f} ({100 * found.low:.1f} to {100 * found.high:.1f})"


@pytest.fixture(scope="session")
def calibration_seed(pytestconfig: pytest.Config) -> int:
    """From which a statistical test draws; printed at the beginning of the run."""
    return pytestconfig.option.seed


@pytest.fixture(scope="session")
def share_of(pytestconfig: pytest.Config) -> Callable[[int], int]:
    """How often to repeat what a whole calibration repeats n times; at least twice."""
    share = pytestconfig.option.share
    return lambda n: min(n, max(2, round(share * n)))


@pytest.fixture
def validation_table(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Hand over a table: title, rows (all with the same columns), and a sentence on what is held against what."""

    def keep(title: str, rows: Rows, note: str = "") -> None:
        plain = [{str(name): _cell(value) for name, value in row.items()} for row in rows]
        request.node.user_properties.append(("validation", {"title": title, "rows": plain, "note": note}))

    return keep


def _cell(value: Any) -> str:
    plain = getattr(value, "item", lambda: value)()  # of a NumPy scalar
    if isinstance(plain, bool):
        return "yes" if plain else "no"
    return f"{plain:.4g}" if isinstance(plain, float) else str(plain)


@dataclass(frozen=True)
class Table:
    """One table of a page: of which test, and whether that passed."""

    module: str
    test: str
    passed: bool
    title: str
    rows: Rows
    note: str

    def lines(self) -> list[str]:
        """As Markdown."""
        names = list(self.rows[0]) if self.rows else []
        cells = [names, ["---"] * len(names), *([row[name] for name in names] for row in self.rows)]
        table = ["| " + " | ".join(text.replace("|", "\\|") for text in line) + " |" for line in cells if names]
        fate = [] if self.passed else ["", "**The test that holds these numbers to its limits failed.**"]
        return [f"## {self.title}", "", *([self.note, ""] if self.note else []), *table, *fate, "", f"Test: `{self.test}`.", ""]


def _merged(tables: Sequence[Table]) -> list[Table]:
    """Tables of one title and with the same columns as one: those of a test that is run for one thing after the other."""
    kept: dict[tuple[str, ...], Table] = {}
    for table in tables:
        key = (table.title, table.note, *(table.rows[0] if table.rows else ()))
        before = kept.get(key)
        if before is None:
            kept[key] = table
        else:
            test = before.test.partition("[")[0]
            kept[key] = replace(before, test=test, passed=before.passed and table.passed, rows=[*before.rows, *table.rows])
    return list(kept.values())


class Pages:
    """In the process that the user started: collects tables and writes a page for each test module."""

    def __init__(self, config: pytest.Config) -> None:
        self.config, self.tables, self.written = config, list[Table](), list[Path]()

    def pytest_report_header(self) -> list[str]:
        options = self.config.option
        return [f"calibrate: seed {options.seed}, share {options.share:g}"] if _asked(self.config) else []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, value in report.user_properties if report.when == "call" else ():
            if name == "validation":
                test = report.nodeid.split("@")[0]
                self.tables.append(Table(test.partition("::")[0], test, report.passed, **value))  # type: ignore[arg-type]

    def pytest_sessionfinish(self) -> None:
        folder = self.config.option.validation
        for module in sorted({table.module for table in self.tables}) if folder else ():
            file = Path(folder) / f"{Path(module).stem.removeprefix('test_').replace('_', '-')}.md"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(self._page(module), encoding="utf-8")
            self.written.append(file)

    def _page(self, module: str) -> str:
        options, stem = self.config.option, Path(module).stem.removeprefix("test_").replace("_", " ")
        made = (
            f"Made by `make calibrate` from `{module}` on {datetime.now(UTC):%Y-%m-%d}, version {_version(self.config.rootpath)}, "
            f"seed {options.seed}, {'whole' if options.share == 1 else f'a share of {options.share:g}'}."
        )
        tables = _merged(sorted((table for table in self.tables if table.module == module), key=lambda table: table.test))
        return "\n".join([f"# {stem.capitalize()}", "", made, "", *(line for table in tables for line in table.lines())]).rstrip() + "\n"

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        for line in (*self.pytest_report_header(), *(f"validation  {file}" for file in self.written)):
            terminalreporter.write_line(line)


def _version(root: Path) -> str:
    said = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=root, capture_output=True, text=True, check=False).stdout.strip()
    return f"{metadata.version('unspool')}{f' ({said})' if said else ''}"


def _asked(config: pytest.Config) -> bool:
    return config.option.calibrate or config.option.markexpr == "calibrate"


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("calibration")
    group.addoption("--calibrate", action="store_true", help="run the tests marked calibrate, and no others")
    group.addoption("--seed", type=int, default=USUAL_SEED, help="of the statistical tests")
    group.addoption("--share", type=float, default=1.0, help="of the calibration that is run, drawn by the seed")
    group.addoption("--validation", metavar="FOLDER", help="write the tables of the calibration as pages to FOLDER")


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Pages(config), "validation-pages")


def _chosen(items: list[pytest.Item], config: pytest.Config) -> set[str]:
    """Names of the calibrating tests that are run: those that repeat by their share, and of the others a share."""
    share, chance = config.option.share, random.Random(config.option.seed)
    scaled = [item for item in items if "share_of" in getattr(item, "fixturenames", ())]
    others = [item for item in items if item not in scaled]
    return {item.nodeid for item in (*scaled, *chance.sample(others, round(share * len(others))))}


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is not asked for."""
    by_name = {argument.partition("[")[0] for argument in config.args if "::" in argument}
    calibrating = [item for item in items if item.get_closest_marker("calibrate")]
    if _asked(config):
        chosen = _chosen(calibrating, config)
        kept = [item for item in items if item.nodeid in chosen]
    else:
        kept = [item for item in items if item not in calibrating or any(str(name) in item.nodeid for name in by_name)]
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = kept
