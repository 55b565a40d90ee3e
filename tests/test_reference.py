"""The reference is written from the code: nothing is left out, formulas stay formulas, and figures show something."""

import ast
import inspect
import re
from dataclasses import fields, is_dataclass
from importlib import import_module

import numpy as np
import pytest
from generator import catalogue, front_doors, levels, model_file
from generator.effect_plots import at_size
from generator.plain_text import escaped, prose, restructured
from generator.units import unit_of

from simulate import Model
from simulate.effects import CATALOGUE

every_effect = pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE.keys())


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("mass_kg", "kg"),
        ("damping_N_s_per_m", "N s/m"),
        ("beta_per_m", "1/m"),
        ("inertia_kg_m2", "kg m²"),
        ("acceleration_m_per_s2", "m/s²"),
        ("b_l_N[0]", "N"),
        ("stored_force_percent", "%"),
        ("fraction", "1"),
        ("abscissa", ""),
    ],
)
def test_the_unit_of_a_name_is_what_stands_at_its_end(name, unit):
    assert unit_of(name) == unit


def test_a_formula_becomes_a_literal_block_and_an_absolute_value_no_substitution():
    made = prose(["A law with |u|:", "", "    F = -k |V| V", "", "k is k_."])
    assert made[0] == r"A law with \|u\|:"
    assert made[made.index("::") + 2] == "    F = -k |V| V"
    assert r"k is k\_." in made


def test_what_stands_in_backquotes_is_left_alone():
    assert escaped("`a_|b|` and *c*") == r"`a_|b|` and \*c\*"


def test_a_parameter_in_one_line_gets_its_description_below_its_name():
    made = restructured(["A sum.", "", "Parameters", "----------", "u, v : (n,) m and m/s.", "    Behind it more.", ""])
    assert made[-4:-1] == ["u, v", "    (n,) m and m/s.", "    Behind it more."]


def test_a_type_behind_the_name_of_a_parameter_stays_there():
    made = restructured(["A sum.", "", "Parameters", "----------", "path : Path or str", "    A local file.", ""])
    assert made[-3:-1] == ["path : Path or str", "    A local file."]


def keys_of(kind):
    own = [item.name for item in fields(kind)]
    inner = [model_file.table_of(hint) for hint in model_file.hints_of(kind).values()]
    return own + [key for table in inner if table is not None and is_dataclass(table) for key in keys_of(table)]


def test_every_key_of_the_model_file_is_on_its_page():
    page = model_file.page()
    missing = [key for key in keys_of(Model) if key != "effects" and f"`{key}`" not in page and f"{key}]`" not in page]
    assert not missing


@pytest.mark.parametrize("package", front_doors.PACKAGES)
def test_every_name_of_a_front_door_has_a_line_that_says_what_it_is(package):
    rows = [line for line in front_doors.page(package).splitlines() if line.startswith("| {py:obj}")]
    assert rows
    assert not [row for row in rows if row.endswith("|  |")]


def functions_of(package):
    exported = ((name, getattr(import_module(package), name)) for name in import_module(package).__all__)
    return {name: thing for name, thing in exported if inspect.isfunction(thing)}


def explained(doc, section):
    """The names that a section of a docstring explains; None where there is no such section."""
    found = re.search(rf"^{section}\n-+\n(.*?)(?=\n\n\w+\n---|\Z)", doc, re.M | re.S)
    return found and {name for names in re.findall(r"^\*{0,2}(\w[\w, ]*?)(?: :.*)?$", found[1], re.M) for name in names.split(", ")}


@pytest.mark.parametrize("package", front_doors.PACKAGES)
def test_every_function_of_a_front_door_says_what_it_takes_gives_and_refuses(package):
    wrong = []
    for name, function in functions_of(package).items():
        doc, signature = inspect.getdoc(function) or "", inspect.signature(function)
        unsaid = set(signature.parameters) - (explained(doc, "Parameters") or set())
        wrong += [f"{name}: Parameters lack {sorted(unsaid)}"] * bool(unsaid)
        wrong += [f"{name}: no Returns"] * (
            signature.return_annotation not in (None, "None") and not re.search(r"^(Returns|Yields)\n-", doc, re.M)
        )
        raises = any(isinstance(node, ast.Raise) for node in ast.walk(ast.parse(inspect.getsource(function))))
        wrong += [f"{name}: no Raises"] * (raises and explained(doc, "Raises") is None)
    assert not wrong, "\n".join(wrong)


@every_effect
def test_every_parameter_of_an_effect_has_its_row_with_bounds_and_meaning(kind):
    page = catalogue.page(kind, "")
    for item in fields(kind):
        row = next(line for line in page.splitlines() if line.startswith(f"| `{item.name}`"))
        assert f"{item.metadata['low']:g} to {item.metadata['high']:g}" in row
        assert item.metadata["doc"]


@every_effect
def test_an_effect_is_drawn_at_a_size_that_is_not_nothing_and_within_its_bounds(kind):
    drawn = at_size(kind)
    assert np.any(drawn.flat() != kind().flat())


def test_every_level_that_decides_has_a_reason():
    found = [(file.parent.name, level) for file in levels.criteria_files() for level in levels.levels_of(file)]
    assert found
    assert not [f"{room}.{level.name}" for room, level in found if not level.reason]
