"""What is drawn where: the numbers that stand in the axes of the figures of the forward problem."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from simulate.report.control_plots import control_figure
from simulate.report.index_plots import indices_figure
from simulate.report.plots import (
    deployment_figure,
    draw_coefficients,
    draw_map,
    draw_responses,
    draw_tolerance,
    gravity_figure,
    sweep_figure,
)

TIME = np.linspace(0.0, 1.0, 5)


@pytest.fixture
def axes():
    return Figure().subplots()


def run_of(prototype, turned_deg=0.0, **changed) -> Any:
    channels = {name: np.zeros(5) for name in ("x_m", "y_m", "theta_x_rad", "theta_y_rad")}
    channels |= {"z_m": 0.25 + 0.1 * TIME, "theta_z_rad": np.radians(turned_deg * TIME)}
    return SimpleNamespace(time_s=TIME, channels=channels, leg_force_N=np.outer(TIME, np.arange(1.0, 7.0)), model=prototype, **changed)


def heights(axes):
    return [bar.get_height() for bar in axes.patches]


def curve(line):
    return np.asarray(line.get_ydata(), dtype=float)


def test_the_largest_coefficients_stand_in_their_order_without_the_constant_and_have_a_colour_by_their_sign(axes):
    draw_coefficients(axes, {"1": 99.0, "A": 1.0, "B": -5.0, "AB": 2.0}, "deg", most=2)
    assert heights(axes) == [-5.0, 2.0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["B", "AB"]
    assert axes.get_title() == "the 2 largest of 3 coefficients"
    down, up = (bar.get_facecolor() for bar in axes.patches)
    assert down != up
    low, high = axes.get_xlim()
    assert (low < -0.4, high > 1.4) == (True, True)


def test_responses_stand_between_their_edges_and_the_limit_on_either_side(axes):
    draw_responses(axes, np.array([1, 4, 2]), np.array([-40.0, -10.0, 10.0, 40.0]), "deg", 30.0)
    assert [line.get_xdata()[0] for line in axes.get_lines()] == [-30.0, 30.0]
    assert axes.get_title() == "7 runs"
    assert axes.patches[0].get_data().values.tolist() == [1, 4, 2]


def test_a_map_goes_up_with_the_first_factor_and_its_colours_are_even_about_zero(axes):
    values = np.add.outer(np.linspace(-3.0, 1.0, 5), np.linspace(0.0, 0.5, 5))
    draw_map(axes, values, ("A", "B"), "deg")
    mesh = axes.collections[0]
    assert np.asarray(mesh.get_array()).reshape(5, 5) == pytest.approx(values)
    assert mesh.get_clim() == (-3.0, 3.0)
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("A, coded", "B, coded")
    corners = np.asarray(mesh.get_coordinates())
    assert corners[0, 0] == pytest.approx([-1.25, -1.25])
    assert corners[-1, -1] == pytest.approx([1.25, 1.25])


def test_a_map_of_nothing_has_colours_all_the_same(axes):
    draw_map(axes, np.zeros((4, 4)), ("A", "B"), "deg")
    assert axes.collections[0].get_clim() == (-1.0, 1.0)


def test_the_line_by_the_slopes_is_the_quantile_times_their_length(axes):
    curve_of = [{"spread_N": 0.01, "angle_deg": 9.0}, {"spread_N": 0.02, "angle_deg": 17.0}]
    draw_tolerance(axes, curve_of, np.array([300.0, -400.0]), 0.95)
    slopes, simulated = axes.get_lines()
    assert np.asarray(slopes.get_xdata(), float) == pytest.approx([10.0, 20.0])
    assert curve(slopes) == pytest.approx(1.959964 * 500.0 * np.array([0.01, 0.02]))
    assert curve(simulated) == pytest.approx([9.0, 17.0])
    assert (axes.get_xlim()[0], axes.get_ylim()[0]) == (0.0, 0.0)
    assert axes.get_title() == "kept in 95 % of the runs"


def test_a_deployment_is_drawn_in_millimetres_degrees_and_newtons(prototype):
    figure = deployment_figure(run_of(prototype, 12.0))
    elevation, rotations, forces, lateral = figure.axes
    assert curve(elevation.get_lines()[0]) == pytest.approx(250.0 + 100.0 * TIME)
    assert [line.get_label() for line in lateral.get_lines()] == ["lateral x", "lateral y"]
    assert curve(rotations.get_lines()[2]) == pytest.approx(12.0 * TIME)
    assert [curve(line)[-1] for line in forces.get_lines()] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


@pytest.mark.parametrize(("turned_deg", "least"), [(0.0, 1.0), (1e-9, 1.0), (12.0, 12.0)])
def test_rounding_is_not_blown_up_and_what_is_large_is_shown_whole(prototype, turned_deg, least):
    figure = deployment_figure(run_of(prototype, turned_deg))
    low, high = figure.axes[1].get_ylim()
    assert least <= high - low < 1.2 * least
    assert low <= 0.0 <= turned_deg <= high
    assert figure.axes[3].get_ylim() == pytest.approx((-0.5, 0.5))


def test_the_gravity_study_has_the_real_force_dashed_and_stowed_and_full_height_as_lines(prototype):
    cases: Any = [SimpleNamespace(run=run_of(prototype), times_the_force=times, label=f"{k} {times}") for times in (1, 4) for k in range(3)]
    (axes,) = gravity_figure(cases).axes
    lines = axes.get_lines()
    assert [line.get_linestyle() for line in lines[:6]] == ["--"] * 3 + ["-"] * 3
    assert [lines[k].get_color() == lines[k + 3].get_color() for k in range(3)] == [True] * 3
    assert [curve(line)[0] for line in lines[6:]] == pytest.approx([252.0, 652.0])


def swept(pair) -> Any:
    levels = np.linspace(-1.0, 1.0, 5)
    return SimpleNamespace(
        coefficients={"1": 0.0, "A": 2.0, "B": 1.0}, unit="deg", limit=None, largest_pair=pair, letters=["A", "B", "C"],
        histogram=lambda: (np.array([1, 2]), np.array([0.0, 1.0, 2.0])), map=lambda one, other: np.add.outer(levels * one, levels * other),
    )  # fmt: skip


NO_CURVE: dict[str, Any] = {"curve": [], "slope_deg_per_N": None, "probability": 0.9}


def test_a_sweep_of_one_factor_has_no_map_and_one_without_tolerance_no_curve():
    axes = sweep_figure(swept((0, 2)), NO_CURVE).axes
    assert [axes[2].get_ylabel(), axes[2].get_xlabel()] == ["A, coded", "C, coded"]
    assert [one.axison for one in axes[:4]] == [True, True, True, False]
    curve_of = [{"spread_N": 0.01, "angle_deg": 9.0}]
    axes = sweep_figure(swept(None), {"curve": curve_of, "slope_deg_per_N": np.ones(6), "probability": 0.9}).axes
    assert [one.axison for one in axes[:4]] == [True, True, False, True]


def test_brakes_are_drawn_by_their_largest_force_and_by_what_they_take_out(prototype):
    def held(force):
        return run_of(
            prototype, force, control_force_N=np.outer(TIME, [force, 0, -2 * force, 0, 0, 0]), effects_J={"controller": -force * TIME}
        )

    figure = control_figure([run_of(prototype, 50.0)], [held(0.1), held(0.2), held(0.6)], [30.0])
    before, _, forces, energy = figure.axes
    assert curve(before.get_lines()[0]) == pytest.approx(50.0 * TIME)
    assert [curve(line)[0] for line in before.get_lines()[1:]] == [-30.0, 30.0]
    assert before.get_title() == "without control, 1 draws"
    assert curve(forces.get_lines()[0]) == pytest.approx(0.4 * TIME)
    assert curve(energy.get_lines()[0]) == pytest.approx(0.2 * TIME)
    ends = np.asarray(energy.collections[0].get_paths()[0].vertices)
    assert (ends[:, 1].min(), ends[:, 1].max()) == (0.0, pytest.approx(0.6))


def rows(**values):
    return {letter: {"value": value, "interval": (value - 0.1, value + 0.2)} for letter, value in values.items()}


@pytest.mark.parametrize(("method", "names"), [("sobol", ("total", "first_order")), ("morris", ("mean_size", "spread"))])
def test_indices_stand_with_the_largest_first_and_come_to_rest_within_their_intervals(method, names):
    found = {names[0]: rows(A=0.2, B=0.7), names[1]: rows(A=0.1, B=0.6)}
    steps = [{"runs": 32, "indices": {names[0]: rows(A=0.3, B=0.6)}}, {"runs": 64, "indices": found}]
    left, right = indices_figure({"method": method, "indices": found, "convergence": steps}, "theta_z_deg", "deg").axes
    assert heights(left) == [0.7, 0.2, 0.6, 0.1]
    assert [label.get_text() for label in left.get_xticklabels()] == ["B", "A"]
    first, _ = (bars.errorbar.lines[2][0].get_segments() for bars in left.containers if hasattr(bars, "errorbar") and bars.errorbar)
    assert first[0][:, 1] == pytest.approx([0.6, 0.9])
    assert [curve(line).tolist() for line in right.get_lines()] == [[0.6, 0.7], [0.3, 0.2]]
    assert np.asarray(right.collections[0].get_paths()[0].vertices)[:, 1].max() == pytest.approx(0.9)
    assert left.get_ylabel() == ("share of the variance" if method == "sobol" else "effect, deg")
