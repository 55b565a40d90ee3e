"""The energy that strips and stops store is the integral of their forces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

from simulate.deployment.energy import energy_balance, stored_in_stops, stored_in_strips
from simulate.model.rig import per_leg, stroke_of


def test_strips_store_what_the_line_in_their_middle_gives_on_the_way_to_full_length(lopsided):
    law, full = lopsided.actuator, stroke_of(lopsided)
    at = np.linspace(0.0, 0.25, 6)
    expected = 0.0
    for leg in range(6):
        a_l, b_l, a_u, b_u = (per_leg(getattr(law, name))[leg] for name in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N"))
        expected += quad(lambda u, a=a_l + a_u, b=b_l + b_u: (a * u + b) / 2.0, at[leg], full[leg])[0]
    assert stored_in_strips(lopsided, at[None])[0] == pytest.approx(expected)


@pytest.mark.parametrize("side", ["full", "stowed"])
def test_a_stop_stores_the_integral_of_its_spring_force_at_either_end(prototype, side):
    stop, p = prototype.end_stop, 0.0013
    force = quad(lambda x: stop.stiffness_N_per_m * x * erf(x / stop.smoothing_m), 0.0, p)[0]
    start = np.zeros(6)
    at = stroke_of(prototype) + p if side == "full" else start - p
    stored = stored_in_stops(prototype, np.stack([start, at, 0.5 * stroke_of(prototype)]))
    assert stored[1] == pytest.approx(6.0 * force, rel=1e-6)
    assert stored[[0, 2]] == pytest.approx([0.0, 0.0])


def test_strips_that_give_all_they_had_have_lost_nothing_and_half_of_it_half(prototype):
    way = np.linspace(0.0, 0.1, 4)[:, None] * np.ones(6)
    given = -np.diff(stored_in_strips(prototype, way[[0, -1]]))[0]
    rest = {"kinetic": np.zeros(4), "by_stops": np.array([0.0, 0.0, -0.1, -0.2]), "by_weight": np.zeros(4)}
    lost = []
    for share in (1.0, 0.5):
        by_legs = share * (stored_in_strips(prototype, way)[0] - stored_in_strips(prototype, way))
        found = energy_balance(prototype, way, {**rest, "by_legs": by_legs}, {})
        lost.append(found["lost_in_hysteresis"][-1])
        assert found["lost_in_stops"] == pytest.approx([0.0, 0.0, 0.1, 0.2])
    assert lost == pytest.approx([0.0, 0.5 * given])
