"""Every example in README, CONTRIBUTING and docs runs as it stands, and shows what it says.

The convention is in CONTRIBUTING.md: `console` and `python` blocks of one document run from top to bottom in one empty
folder with the datasets in it. What a console block shows must be printed, numbers aside; a line of three dots stands for
anything. Links into the generated reference are checked by `make docs`. Our own commands run in the process of the test, where
everything is imported; that they are installed under their names is held by what their `--help` prints.
"""

from __future__ import annotations

import glob
import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from identify.commands.subcommands.tasks import TASKS

ROOT = Path(__file__).resolve().parents[1]
COMMANDS: dict[str, str] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
README, TUTORIAL = ROOT / "README.md", ROOT / "docs" / "tutorial.ipynb"
PAGES = sorted(path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts)
DOCUMENTS = [README, ROOT / "CONTRIBUTING.md", *PAGES]
BESIDE_PYTHON = Path(sys.executable).parent


def name_of(document: Path) -> str:
    """How a test calls a document: `how-to/track-video`."""
    return document.relative_to(ROOT).with_suffix("").as_posix().removeprefix("docs/")


every_document = pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)


def blocks(document: Path) -> list[tuple[str, str]]:
    """Language and content of each fenced block."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", document.read_text(encoding="utf-8"), re.M | re.S)


def typed(block: str) -> Iterator[tuple[str, int, list[str]]]:
    """What is typed behind each `$`, the exit status it ends with, and the lines it shows."""
    for part in re.split(r"^\$ ", block, flags=re.M)[1:]:
        line, *shown = part.replace("\\\n", " ").splitlines()
        status = re.search(r"# exit status (\d)$", line)
        yield line, int(status[1]) if status else 0, [text for text in shown if text.strip() not in ("", "...")]


def numberless(text: str) -> str:
    """The words of a line; digits and blanks differ from machine to machine."""
    return " ".join(re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", text).split())


def words_of(line: str) -> list[str]:
    """What a shell makes of a line: without its comment, names with a star as those of the files."""
    return [name for word in shlex.split(line, comments=True) for name in (sorted(glob.glob(word)) or [word])]


def answered(line: str, capfd: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Status of a line that is typed in the present folder, and what it prints; what is no command of ours is the shell's."""
    words = words_of(line)
    if words[0] not in COMMANDS:
        ran = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
        return ran.returncode, ran.stdout + ran.stderr
    module, function = COMMANDS[words[0]].split(":")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", words)
        try:
            status = getattr(import_module(module), function)(words[1:])
        except SystemExit as end:
            status = int(end.code or 0)
    return status, "".join(capfd.readouterr())


def run_console(block: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Type a console block, and look for each of its lines, in their order, in what is printed."""
    for line, status, shown in typed(block):
        ended, said = answered(line, capfd)
        assert ended == status, f"{line}\nends with status {ended} and not {status}:\n{said}"
        printed = iter([numberless(text) for text in said.splitlines()])
        for text in shown:
            assert numberless(text) in printed, f"{line}\ndoes not print, or not in this order:\n{text}\nbut:\n{said}"


def run_python(block: str, file: Path, module: ModuleType) -> None:
    """Run a Python block as a file of its own, because compiled formulas are kept beside their source."""
    file.write_text(block, encoding="utf-8")
    exec(compile(block, file, "exec", dont_inherit=True), vars(module))


def cells_of(notebook: Path) -> list[dict[str, Any]]:
    """The cells of code in a notebook."""
    return [cell for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


def inner_imports(source: str) -> list[str]:
    """Imports of what a package does not export; `simulate.effects` is a front door of its own."""
    return re.findall(r"^\s*(?:from|import) (?:measure|simulate(?!\.effects import)|identify)\.[\w.]+.*$", source, re.M)


@cache
def options(command: str) -> frozenset[str]:
    """The options in a command's help, and in that of its tasks."""
    helps = [[BESIDE_PYTHON / command, *task, "--help"] for task in ([[], *([name] for name in TASKS)] if command == "unspool" else [[]])]
    said = "".join(subprocess.run(words, capture_output=True, text=True, check=True).stdout for words in helps)
    return frozenset(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", said))


def has_examples(document: Path) -> bool:
    """Whether anything in a document is run."""
    return any(language in ("console", "python") for language, _ in blocks(document))


@pytest.mark.slow
@pytest.mark.parametrize("document", [path for path in DOCUMENTS if has_examples(path)], ids=name_of)
def test_examples_run_and_show_what_they_say(document, tmp_path, monkeypatch, capfd):
    if "datasets/" in document.read_text(encoding="utf-8"):
        shutil.copytree(ROOT / "datasets", tmp_path / "datasets")
    monkeypatch.chdir(tmp_path)
    module = ModuleType("example")
    monkeypatch.setitem(sys.modules, "example", module)
    for number, (language, block) in enumerate(blocks(document)):
        if language == "console":
            run_console(block, capfd)
        elif language == "python":
            run_python(block, tmp_path / f"example_{number}.py", module)


@pytest.mark.slow
def test_the_tutorial_runs_from_top_to_bottom(tmp_path):
    import nbformat
    from nbclient import NotebookClient

    shutil.copytree(ROOT / "datasets", tmp_path / "datasets")
    (tmp_path / "docs").mkdir()
    notebook = nbformat.read(TUTORIAL, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "the tutorial is kept without its outputs"
    NotebookClient(notebook, timeout=None, kernel_name="python3", resources={"metadata": {"path": str(tmp_path / "docs")}}).execute()
    shown = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", ()))
    assert "verdict: named" in shown
    assert re.search(r"HubInertia\(mass_kg=\S*0\.0100\d*\)?, 95 %", shown), shown
    assert "cannot be told from: nothing else" in shown


def test_the_tutorial_imports_from_the_front_doors_only():
    source = "\n".join(cell["source"] if isinstance(cell["source"], str) else "".join(cell["source"]) for cell in cells_of(TUTORIAL))
    assert inner_imports(source) == []


@every_document
def test_examples_import_from_the_front_doors_only(document):
    found = [line for language, block in blocks(document) if language == "python" for line in inner_imports(block)]
    assert name_of(document) == "CONTRIBUTING" or not found, f"{document.name}: {found}"


@every_document
def test_options_shown_with_a_command_exist(document):
    lines = document.read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
    shown = [line.strip(" $`") for line in lines]
    for line in shown:
        command = line.split(" ", 1)[0]
        if command in COMMANDS:
            used = set(re.findall(r"(?<=\s)--?[a-z][a-z-]*", line.split("#")[0]))
            assert used <= options(command), f"{document.name}: {line}"


def test_every_command_is_shown_in_the_readme_with_an_example_that_runs():
    shown = [line for language, block in blocks(README) if language == "console" for line, _, _ in typed(block)]
    assert {line.split()[0] for line in shown} >= set(COMMANDS)


def test_every_file_of_the_datasets_has_its_row_in_the_readme():
    rows = re.findall(r"^\| `(datasets/[^`]+)`", README.read_text(encoding="utf-8"), re.M)
    files = [path.relative_to(ROOT).as_posix() for path in (ROOT / "datasets").rglob("*") if path.is_file()]
    shipped = [name for name in files if "__pycache__" not in name]
    missing = [name for name in shipped if name not in rows and not any(name.startswith(row) for row in rows if row.endswith("/"))]
    assert not missing, f"README.md has no row for {missing}; a row begins with the file, or its folder and a slash, in backquotes"
    assert all((ROOT / row).exists() for row in rows)


@every_document
def test_links_between_documents_lead_somewhere(document):
    for target in re.findall(r"\]\((?!https?:|#)([^)#]+)", document.read_text(encoding="utf-8")):
        place = document.parent / target
        assert place.exists() or "reference/generated" in place.as_posix(), f"{document.name}: {target}"


@every_document
def test_files_and_folders_that_a_document_names_are_there(document):
    text = document.read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:measure|simulate|identify|tests|docs|datasets|\.ci)/[\w./-]*)`", text))
    missing = [name for name in sorted(named) if not (ROOT / name).exists() and "calibration" not in name]
    assert not missing, f"{document.name} names {missing}"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_guide_of_a_command_shows_all_its_options(command):
    guide = (ROOT / "docs" / "how-to" / f"{command}.md").read_text(encoding="utf-8")
    common = (ROOT / "docs" / "how-to" / "index.md").read_text(encoding="utf-8")
    missing = [option for option in sorted(options(command)) if option.startswith("--") and f"{option}" not in guide + common]
    assert not missing, f"docs/how-to/{command}.md does not show {missing}"


@every_document
def test_functions_that_a_document_places_in_a_file_are_there(document):
    placed = re.findall(r"`((?:measure|simulate|identify)/[\w/]+\.py)`, `(\w+)`", document.read_text(encoding="utf-8"))
    missing = [(file, name) for file, name in placed if f" {name}(" not in (ROOT / file).read_text(encoding="utf-8")]
    assert not missing, f"{document.name} names {missing}"
