"""Units as people write them, and what one of each is in SI."""

from __future__ import annotations

import pytest

from measure.common.errors import InputError
from measure.tables.units import known_unit, quantity_of, split_unit, turned, unit_of


@pytest.mark.parametrize(
    ("quantity", "text", "factor"),
    [
        ("time", "s", 1.0), ("time", "ms", 1e-3), ("time", "us", 1e-6), ("time", "min", 60.0), ("time", "seconds", 1.0),
        ("elongation", "m", 1.0), ("elongation", "cm", 0.01), ("elongation", "mm", 1e-3), ("elongation", "um", 1e-6),
        ("elongation", "in", 0.0254), ("elongation", "inches", 0.0254), ("elongation", "Micron", 1e-6),
        ("force", "N", 1.0), ("force", "kN", 1e3), ("force", "mN", 1e-3), ("force", "uN", 1e-6), ("force", "kgf", 9.80665),
        ("force", "gf", 9.80665e-3), ("force", "lbf", 4.4482216152605), ("force", "ozf", 4.4482216152605 / 16),
        ("force", "kip", 4448.2216152605),
        ("position", "mm", 1e-3), ("angle", "deg", 0.017453292519943295), ("angle", "rad", 1.0),
    ],
)  # fmt: skip
def test_one_of_a_unit_in_si(quantity, text, factor):
    assert unit_of(quantity, text).factor == pytest.approx(factor, rel=1e-12)


def test_a_factor_turns_volts_and_signs():
    assert unit_of("force", "V*25").factor == 25.0
    assert unit_of("elongation", "mm*-1").factor == pytest.approx(-1e-3)
    assert unit_of("elongation", "mm * 2.5").factor == pytest.approx(2.5e-3)
    assert unit_of("force", turned("V*0.05")).factor == -0.05
    assert unit_of("elongation", turned("mm")).factor == pytest.approx(-1e-3)
    assert unit_of("elongation", turned(turned("mm"))).factor == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("quantity", "text", "said"),
    [
        ("force", "V", "force=V[*]FACTOR with FACTOR in N per volt"),
        ("position", "V", "in m per volt"),
        ("force", "mm", '"mm" is no unit of force'),
        ("force", "N*0", '"0" is no factor'),
        ("force", "N*inf", '"inf" is no factor'),
        ("force", "N*x", '"x" is no factor'),
    ],
)
def test_what_is_no_unit_is_refused(quantity, text, said):
    with pytest.raises(InputError, match=said):
        unit_of(quantity, text)


@pytest.mark.parametrize(
    ("header", "parts"),
    [
        ("Load (kN)", ("Load", "kN")), ("Load [kN]", ("Load", "kN")), ("load_kN", ("load", "kN")), ("x[3]", ("x[3]", "")),
        ("time_s", ("time", "s")), ("max_load", ("max_load", "")), ("Load", ("Load", "")), ("Weg\uff08mm\uff09", ("Weg", "mm")),
    ],
)  # fmt: skip
def test_a_unit_stands_behind_its_name(header, parts):
    assert split_unit(header) == parts


def test_a_header_of_a_thousand_letters_is_looked_at_and_a_longer_one_is_not():
    assert split_unit("x" * 995 + " (mm)")[1] == "mm"
    assert split_unit("x" * 996 + " (mm)")[1] == ""


def test_a_unit_tells_its_quantity():
    assert [quantity_of(unit) for unit in ("ms", "mm", "kN", "bar")] == ["time", "elongation", "force", ""]
    assert known_unit("force", "Newton") == "N"
    assert known_unit("force", "mm") == ""
