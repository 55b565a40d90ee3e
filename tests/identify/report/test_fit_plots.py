"""The figures of a fit: every figure of the paper's kind is there, with units, in colours that the colour-blind tell apart."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from identify.report.fit_plots import FILES, NAMES, drawings, save_figure_file, save_figures
from identify.report.phrases import with_error
from measure import Loop
from measure.common.figure_plots import COLOURS
from simulate.effects import HubInertia
from simulate.loop import loop_force
from simulate.model.effect import Effect

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
GREYS = {"#000000", "#ffffff", "#595959", "#808080"}


def shaken(frequency, amplitude=0.05, effects: tuple[Effect, ...] = (), pressure=0.0):
    t = np.arange(int(3.3 / frequency * 200) * 10) / 2000.0
    w = 2 * np.pi * frequency
    u, v, a = 0.25 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(LINES, t, u, v, a, 2.8, effects)[::10]
    rng = np.random.default_rng(int(10 * frequency))
    noise = 2e-3 * rng.standard_normal(len(force))
    return prepare(
        Loop(t[::10], u[::10], force + noise + 0.5 * pressure, f"{frequency:g}Hz.csv", other={"bar": np.full(len(force), pressure)})
    )


@pytest.fixture(scope="module")
def drawn():
    loops = [shaken(f, a, (HubInertia(0.03),)) for f in (0.5, 1.0, 3.0) for a in (0.05, 0.02)]
    fit = fit_actuator(loops, (HubInertia,), "frequency_Hz", 1)
    return fit, drawings(fit, fit.profile())


def titled(drawn, word):
    return next(axes for one in drawn for axes in one.figure.axes if word in axes.get_title())


KINDS = ["loops and law", "what is left", "by stroke", "by frequency", "elongation explains", "speed explains", "time explains"]
KINDS += ["levels", "slopes", "stiffness by frequency", "stiffness by amplitude", "transition zone", "profile of beta"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_of_the_papers_kind_is_there_with_units(drawn, kind):
    axes = titled(drawn[1], kind)
    for label in (axes.get_xlabel(), axes.get_ylabel()):
        assert label.endswith(")") or kind == "profile of beta"
        assert "(" in label or label == "rise of the misfit"


def test_the_colours_are_those_that_the_colour_blind_tell_apart(drawn):
    allowed = GREYS | {colour.lower() for colour in COLOURS}
    for one in drawn[1]:
        for axes in one.figure.axes:
            assert {to_hex(line.get_color()) for line in axes.lines} <= allowed


def test_the_first_page_has_two_panels_and_the_numbers(drawn):
    figure = drawn[1][0].figure
    panels = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title().split(":")[0].split(",")[0] for axes in panels] == ["loops and law", "what is left"]
    words = "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert all(word in words for word in ("beta_per_m", "chi-square", "AIC", "BIC", "points", "half height"))
    assert "ok" in figure.get_suptitle()


def test_a_figure_has_a_question_and_a_file_of_its_own(drawn, tmp_path):
    assert [one.name for one in drawn[1]] == list(NAMES[:-1])  # no covariate
    assert all(one.figure.get_suptitle().endswith("?") for one in drawn[1][1:])
    save_figures(drawn[1][-1:], tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["09-correlations.pdf", "09-correlations.png"]
    assert {path.name for path in tmp_path.iterdir()} < set(FILES)


def test_a_pdf_holds_all_figures_and_a_picture_the_first(drawn, tmp_path):
    for ending in ("pdf", "svg"):
        save_figure_file(drawn[1], tmp_path / f"x.{ending}")
    assert f"/Count {len(drawn[1])}".encode() in (tmp_path / "x.pdf").read_bytes()
    assert b"<svg" in (tmp_path / "x.svg").read_bytes()


def test_loops_side_by_side_differ_in_what_the_title_says(drawn):
    labels = {word: [line.get_label() for line in titled(drawn[1], word).lines] for word in ("by stroke", "by frequency")}
    assert {label.split(",")[0] for label in labels["by stroke"]} == {"0.5 Hz"}
    assert len(labels["by frequency"]) == 3
    assert len({label.split("stroke")[1] for label in labels["by frequency"]}) == 1


def test_marks_of_single_loops_lie_on_what_was_fitted_to_all(drawn):
    axes = titled(drawn[1], "levels")
    marks = [line for line in axes.lines if line.get_label().startswith("lower") and line.get_linestyle() == "None"]
    seen = marks[0].get_ydata()
    assert np.asarray(seen) == pytest.approx(np.full(6, 2.79 - 0.25 * 0.25), abs=2e-3)


def test_the_polynomials_stand_beside_their_curves_with_errors(drawn):
    figure = next(one.figure for one in drawn[1] if one.name == "05-asymptotes")
    words = "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert "at 1.75 Hz" in words
    assert words.count("±") == 4 * (3 + 2)


def test_the_profile_crosses_where_its_interval_ends(drawn):
    fit, made = drawn
    line = titled(made, "profile of beta").lines[0]
    low, high = fit.profile().interval
    assert np.interp([low, high], line.get_xdata(), line.get_ydata()) == pytest.approx(3.84, abs=0.1)


@pytest.mark.parametrize("loops", [[shaken(1.0)], [shaken(1.0), shaken(2.0, 0.02)]])
def test_one_loop_or_loops_without_a_partner_have_figures_too(loops):
    made = drawings(fit_actuator(loops))
    assert titled(made, "loops and law").lines
    assert {one.name for one in made} >= {"01-fit", "02-each-loop", "04-residual", "09-correlations"}


def test_with_a_covariate_the_corrected_loops_lie_on_one_another():
    loops = [shaken(1.0, pressure=p) for p in (0.0, 1.0, 4.0)]
    made = drawings(fit_actuator(loops, covariate="bar"))
    before, after = made[-1].figure.axes
    heights = [[np.mean(line.get_ydata()) for line in axes.lines] for axes in (before, after)]
    assert np.ptp(heights[0]) == pytest.approx(2.0, abs=0.02)
    assert np.ptp(heights[1]) < 0.01
    first = titled(made, "loops and law")
    assert np.ptp([np.mean(line.get_ydata()) for line in first.lines[:3]]) < 0.01


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [(399.84, 0.92, "399.84 ± 0.92"), (441.6, 170.0, "440 ± 170"), (-0.30123, 0.0023, "-0.3012 ± 0.0023"), (5.0, 0.0, "5 ± 0")],
)
def test_a_number_has_as_many_decimals_as_are_known(value, error, shown):
    assert with_error(value, error) == shown
