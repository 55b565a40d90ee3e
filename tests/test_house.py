"""The house keeps its order: who imports whom, what is installed, what starts at once, what no file says."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import metadata, util
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
COMMANDS = PROJECT["project"]["scripts"]
MAY_IMPORT = {"measure": {"measure"}, "simulate": {"measure", "simulate"}, "identify": {"measure", "simulate", "identify"}}
ROOMS = tuple(MAY_IMPORT)
HEAVY = {"cv2", "jinja2", "lmfit", "matplotlib", "numba", "numpy", "pandas", "pydantic", "scipy"}


@dataclass(frozen=True)
class Import:
    """One name imported somewhere: by which file, from which module, and whether only when a function runs."""

    file: Path
    module: str
    lazy: bool

    @property
    def top(self) -> str:
        return self.module.partition(".")[0]

    def __str__(self) -> str:
        return f"{self.file} imports {self.module}"


def _sources(*folders: str) -> list[Path]:
    return [path.relative_to(ROOT) for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def _absolute(file: Path, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    return ".".join((*file.parts[: -node.level], *([node.module] if node.module else [])))


def _walk(file: Path, node: ast.AST, lazy: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (Import(file, alias.name, lazy) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            module = _absolute(file, child)
            yield from (Import(file, f"{module}.{alias.name}", lazy) for alias in child.names)
        else:
            later = isinstance(child, ast.FunctionDef) or (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test))
            yield from _walk(file, child, lazy or later)


@cache
def _imports(*folders: str) -> tuple[Import, ...]:
    return tuple(
        found for file in _sources(*folders) for found in _walk(file, ast.parse((ROOT / file).read_text(encoding="utf-8")), lazy=False)
    )


def _of(library: str) -> list[Import]:
    return [found for found in _imports(*ROOMS) if found.top == library]


def _is_command(file: Path) -> bool:
    return file.parent.name == "commands"


def _draws(file: Path) -> bool:
    return file.stem.endswith("plots")


def _reports(file: Path) -> bool:
    return file.parent.name == "report"


def _said(wrong: list[Import]) -> str:
    return "; ".join(map(str, wrong))


def test_imports_run_one_way_from_identify_to_measure():
    wrong = [found for found in _imports(*ROOMS) if found.top in ROOMS and found.top not in MAY_IMPORT[found.file.parts[0]]]
    assert not wrong, _said(wrong)


FULL_FOLDER, MOST_LEVELS = 15, 11
CATALOGUE = Path("simulate", "effects")  # one file an effect, however many there are
HOMES = {"criteria", "limits", "layout", "model_rows", "units"}  # modules that hold numbers for others


def _module(file: Path) -> str:
    parts = file.parts[:-1] if file.stem == "__init__" else file.with_suffix("").parts
    return ".".join(parts)


@cache
def _graph() -> dict[str, set[str]]:
    """Who needs whom, also where only a function or a type checker does."""
    modules = {_module(file) for file in _sources(*ROOMS)}
    needs: dict[str, set[str]] = {module: set() for module in modules}
    for found in _imports(*ROOMS):
        whole, above = found.module, found.module.rpartition(".")[0]
        target = whole if whole in modules else above
        if target in modules and target != _module(found.file):
            needs[_module(found.file)].add(target)
    return needs


@cache
def _circles() -> tuple[tuple[str, ...], ...]:
    """Circles of imports, each once, as the modules along it."""
    found: dict[frozenset[str], tuple[str, ...]] = {}
    done: set[str] = set()

    def walk(module: str, way: tuple[str, ...]) -> None:
        if module in way:
            circle = way[way.index(module) :]
            found.setdefault(frozenset(circle), circle)
        elif module not in done:
            for needed in sorted(_graph()[module]):
                walk(needed, (*way, module))
            done.add(module)

    for module in sorted(_graph()):
        walk(module, ())
    return tuple(found.values())


def _chain(module: str, room: str, known: dict[str, list[str]]) -> list[str]:
    """The longest way down through the room's own imports, from a module to one that needs none."""
    if module not in known:
        known[module] = [module]  # in a circle, the way ends where it began
        below = [_chain(needed, room, known) for needed in sorted(_graph()[module]) if needed.split(".")[0] == room]
        known[module] = [module, *max(below, key=len, default=[])]
    return known[module]


def _number(node: ast.expr) -> bool:
    """Whether an expression is made of numbers alone, of which one is no whole number: whole ones are places, states and counts."""
    return all(isinstance(part, ast.Constant | ast.UnaryOp | ast.BinOp | ast.operator | ast.unaryop) for part in ast.walk(node)) and any(
        isinstance(part, ast.Constant) and isinstance(part.value, float) for part in ast.walk(node)
    )


@cache
def _levels() -> frozenset[str]:
    """Numbers in capitals at the top of a module, with their module."""
    return frozenset(
        f"{_module(file)}.{name.id}"
        for file in _sources(*ROOMS)
        for node in ast.parse((ROOT / file).read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign)
        for target in node.targets
        for name, value in _named(target, node.value)
        if name.id.isupper() and _number(value)
    )


def _named(target: ast.expr, value: ast.expr) -> list[tuple[ast.Name, ast.expr]]:
    if isinstance(target, ast.Name):
        return [(target, value)]
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        return [(name, one) for name, one in zip(target.elts, value.elts, strict=True) if isinstance(name, ast.Name)]
    return []


def test_no_folder_holds_more_modules_than_one_can_survey():
    counts = {folder: len(list(folder.glob("*.py"))) for folder in {(ROOT / path).parent for path in _sources(*ROOMS)}}
    full = {str(folder.relative_to(ROOT)): n for folder, n in counts.items() if n > FULL_FOLDER + (folder / "__init__.py").exists()}
    assert set(full) <= {str(CATALOGUE)}, full


def _still(reason: str, *rooms: str) -> list[Any]:
    """The rooms, of which some do not keep a rule yet; whoever mends the last one of a room takes its name away."""
    mark = pytest.mark.xfail(strict=True, reason=reason)
    return [pytest.param(room, marks=mark if room in rooms else ()) for room in ROOMS]


@pytest.mark.parametrize("room", ROOMS)
def test_imports_of_modules_never_form_a_circle(room):
    circles = [" -> ".join((*circle, circle[0])) for circle in _circles() if circle[0].split(".")[0] == room]
    assert not circles, "; ".join(circles)


@pytest.mark.parametrize("room", ROOMS)
def test_no_module_stands_on_more_than_eleven_levels_of_its_own_package(room):
    known: dict[str, list[str]] = {}
    deepest = max((_chain(module, room, known) for module in sorted(_graph()) if module.split(".")[0] == room), key=len)
    assert len(deepest) <= MOST_LEVELS, f"{len(deepest)} levels: {' -> '.join(deepest)}"


def test_no_module_imports_a_private_name_of_another():
    wrong = [f for f in _imports(*ROOMS) if f.top in ROOMS and f.module.rpartition(".")[2].startswith("_")]
    assert not wrong, _said(wrong)


@pytest.mark.parametrize("room", _still("levels stand where they were first used"))
def test_a_level_that_several_modules_use_stands_in_a_module_of_levels(room):
    taken = [found for found in _imports(room) if found.module in _levels()]
    wrong = [found for found in taken if found.module.split(".")[-2] not in HOMES]
    assert not wrong, _said(wrong)


def test_nothing_installed_imports_tests_or_datasets():
    wrong = [found for found in _imports(*ROOMS) if found.top in ("tests", "datasets")]
    assert not wrong, _said(wrong)


def test_pictures_are_decoded_in_measure_only():
    wrong = [found for found in _of("cv2") if found.file.parts[0] != "measure"]
    assert not wrong, _said(wrong)


def test_lmfit_stays_in_fitting_modules_and_is_loaded_only_when_a_fit_is_asked_for():
    apart = [f for f in _of("lmfit") if f.file.parts[0] != "identify" or _is_command(f.file) or _draws(f.file) or _reports(f.file)]
    assert not apart, _said(apart)
    early = [found for found in _of("lmfit") if not found.lazy]
    assert not early, _said(early)


def test_kernels_are_not_compiled_in_commands_figures_or_package_files():
    wrong = [f for f in _of("numba") if _is_command(f.file) or _draws(f.file) or _reports(f.file) or f.file.stem == "__init__"]
    assert not wrong, _said(wrong)


def test_figures_are_drawn_in_plots_modules_on_axes_that_those_or_commands_make():
    wrong = [found for found in _of("matplotlib") if not (_draws(found.file) or _is_command(found.file)) or not found.lazy]
    assert not wrong, _said(wrong)


def test_plots_modules_serve_commands_and_reports_only():
    by_others = [f for f in _imports(*ROOMS) if not (_is_command(f.file) or _reports(f.file) or _draws(f.file))]
    wrong = [f for f in by_others if any(part.endswith("plots") for part in f.module.split(".")) and f.top in ROOMS]
    assert not wrong, _said(wrong)


def test_no_module_is_called_cli():
    assert not [path for path in _sources(*ROOMS, "tests", "datasets") if "cli" in (path.stem, *path.parts)]


def test_no_folder_of_tests_is_a_package():
    packages = [path for path in _sources("tests", "datasets") if path.name == "__init__.py"]
    assert not packages, f"{packages}: take it away; tests/identify as a package would hide the package identify"


def test_only_the_named_things_stand_at_the_root():
    files = {path.name for path in ROOT.iterdir() if path.is_file() and not path.name.startswith(".")}
    about = {"CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "SECURITY.md"}
    assert files == about | {"Makefile", "constraints.txt", "pyproject.toml"}
    folders = {path.name for path in ROOT.iterdir() if (path / "__init__.py").exists()}
    assert folders == set(ROOMS)


def _distribution(name: str) -> str:
    return re.sub(r"[-_.]+", "-", re.split(r"[ \[<>=!~;]", name)[0]).lower()


def _declared(*, with_groups: bool) -> set[str]:
    listed = [*PROJECT["project"]["dependencies"], *(e for extra in PROJECT["project"]["optional-dependencies"].values() for e in extra)]
    if with_groups:
        listed += [entry for group in PROJECT["dependency-groups"].values() for entry in group if isinstance(entry, str)]
    return {_distribution(entry) for entry in listed}


def _undeclared(folders: tuple[str, ...], declared: set[str]) -> list[str]:
    provided_by = metadata.packages_distributions()
    foreign = [found for found in _imports(*folders) if found.top not in (*ROOMS, "tests", *sys.stdlib_module_names)]
    neighbours = {name for path in _sources(*folders) for name in (path.stem, *path.parent.parts)}
    return [
        str(found)
        for found in foreign
        if found.top not in neighbours and declared.isdisjoint(map(_distribution, provided_by.get(found.top, [found.top])))
    ]


def test_every_library_imported_by_the_packages_is_a_declared_dependency():
    assert not _undeclared(ROOMS, _declared(with_groups=False))


def test_every_library_imported_by_tests_or_datasets_is_declared_too():
    mirrored = (
        *(f"tests/{room}" for room in (*ROOMS, "hidden", "plugins", "robust")),
        "datasets",
        "supply-chain",
    )  # benchmarks compare with what others have written
    assert not _undeclared(mirrored, _declared(with_groups=True))


def test_every_declared_dependency_is_imported_somewhere():
    provided_by = metadata.packages_distributions()
    used = {_distribution(name) for found in _imports(*ROOMS) for name in provided_by.get(found.top, [found.top])}
    needed = {_distribution(entry) for entry in PROJECT["project"]["dependencies"]}
    assert needed <= used, f"declared and imported by nobody: {needed - used}"


def test_every_dependency_is_pinned():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    pinned = {_distribution(line) for line in lines}
    assert all(re.fullmatch(r"[\w.-]+==[\w.+!-]+", line) for line in lines)
    assert _declared(with_groups=True) | {"pip", "hatchling", "editables"} <= pinned


WHERE = "import {name}, os; print(os.path.realpath({name}.__file__))"


def _foreign(name: str, where: str, root: Path) -> str:
    """The sentence for a package of somebody else under our name; empty if it is ours."""
    if Path(where).is_relative_to(root):
        return ""
    return (
        f'the package "{name}" is imported from {where} and not from {root}: another distribution owns that name here '
        '("identify" is also a library inside pre-commit). Give the project an environment of its own: make test.'
    )


@pytest.mark.parametrize("name", ROOMS)
def test_the_package_imported_under_our_name_is_ours(name):
    spec = util.find_spec(name)
    assert spec is not None, f'"{name}" is not installed; make test installs it'
    assert spec.origin is not None
    sentence = _foreign(name, str(Path(spec.origin).resolve()), ROOT)
    assert not sentence, sentence


def test_a_foreign_identify_is_answered_with_a_sentence(tmp_path):
    (tmp_path / "identify").mkdir()
    (tmp_path / "identify" / "__init__.py").write_text("")
    ran = subprocess.run([sys.executable, "-c", WHERE.format(name="identify")], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "an environment of its own" in _foreign("identify", ran.stdout.strip(), ROOT)


HELP = """
import sys, time
from {module} import {function} as main
try:
    main(["--help"])
except SystemExit as end:
    assert not end.code
print("LOADED", *sorted(set(sys.modules) & {heavy}))
print("SPENT", time.process_time())
"""


@pytest.mark.parametrize("name", COMMANDS)
def test_help_answers_without_loading_a_heavy_library(name):
    module, function = COMMANDS[name].split(":")
    code = HELP.format(module=module, function=function, heavy=HEAVY)
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith(f"usage: {name} ")
    *_, loaded, spent = ran.stdout.splitlines()
    assert loaded.split() == ["LOADED"]
    assert float(spent.split()[1]) < 1.0  # of processor time; about 0.1 where nothing heavy is loaded


@pytest.mark.parametrize("name", COMMANDS)
def test_help_ends_with_two_examples_exit_status_and_the_page_that_says_more(name, capfd):
    module, function = COMMANDS[name].split(":")
    with pytest.raises(SystemExit):
        getattr(__import__(module, fromlist=[function]), function)(["--help"])
    ending = capfd.readouterr().out.split("examples:\n")[1].lower()
    assert ending.count(f"  {name} ") >= 2
    assert "exit status: 0 done" in ending
    assert "70 a fault of the program" in ending
    assert (ROOT / "docs" / "how-to" / f"{name}.md").exists()


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_knows_the_common_options_and_answers_a_wrong_one_with_the_nearest(name, capfd):
    module, function = COMMANDS[name].split(":")
    main = getattr(__import__(module, fromlist=[function]), function)
    with pytest.raises(SystemExit):
        main(["--help"])
    usage = capfd.readouterr().out
    assert all(option in usage for option in ("--output", "--json", "--quiet", "--help"))
    assert main(["no-such-file", "no-such-file", "--qiet"]) == 2
    assert capfd.readouterr().err.startswith(f"{name}: error: ")


def _texts() -> list[Path]:
    kept = {".csv", ".j2", ".json", ".md", ".py", ".toml", ".txt"}
    folders = (*ROOMS, "tests", "docs", "datasets", "supply-chain", ".ci")
    inside = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    return [path for path in (*ROOT.iterdir(), *inside) if path.is_file() and (path.suffix in kept or path.name in ("run", "Makefile"))]


def test_no_text_names_a_package_index_or_a_place_on_somebodys_machine():
    index = "|".join(("py" + r"pi\.", "python" + "hosted", r"index" + "-url", r"find" + "-links"))
    place = r"(?<![\w.$)}/])/" + "(?:" + "|".join(("home", "root", "Users", "work", "opt", "mnt")) + r")/\w"
    pattern = re.compile(f"{index}|{place}|[A-Z]:" + r"\\Users")
    found = [f"{path.relative_to(ROOT)}: {hit.group()}" for path in _texts() for hit in pattern.finditer(path.read_text(encoding="utf-8"))]
    assert not found, found


def test_ci_calls_the_make_targets_that_exist():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    called = set(re.findall(r"^(?:step|reported \d+) ([a-z]+)", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.M))
    assert called >= {"test", "lint", "demo", "calibrate"}
    assert called | {"datasets", "fast", "clean"} <= targets
