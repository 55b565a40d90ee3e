"""Numbers in the units that people use, with the digits that their intervals carry."""

import math

import pytest

from measure.pages.in_use import in_use


@pytest.mark.parametrize(
    ("name", "value", "ends", "words"),
    [
        ("mass_kg", 0.010008, (0.009996, 0.010021), "10.008 g (9.996 to 10.021 g)"),
        ("mass_kg", 0.0100, (0.0098, 0.0102), "10.00 g (9.80 to 10.20 g)"),
        ("mass_kg", 12.0, (11.0, 13.0), "12.0 kg (11.0 to 13.0 kg)"),
        ("force_N[3]", -0.0213, (), "-21.3 mN"),
        ("theta_rad", math.pi / 180, (), "1.00 deg"),
        ("gap_m", 0.00123, (), "1.23 mm"),
        ("fraction", 0.05, (0.04, 0.06), "5.0 % (4.0 to 6.0 %)"),
        ("damping_N_s_per_m", 0.62, (), "0.620 N s/m"),
        ("exponent", 2.0, (1.5, 2.5), "2.0 (1.5 to 2.5)"),
        ("mass_kg", 0.01, (math.nan, math.nan), "10.0 g"),
        ("mass_kg", math.nan, (), "–"),
        ("stiffness_N_per_m", 2.0e7, (), "2e+07 N/m"),
    ],
)
def test_a_number_is_told_as_people_tell_it(name, value, ends, words):
    assert in_use(name, value, ends) == words
