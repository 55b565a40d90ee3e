"""The page of a fit: every figure of the paper's kind is there, with units, and can be read in grey."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from identify.report.loop_plots import page
from measure import Loop
from simulate.effects import HubInertia
from simulate.loop import loop_force
from simulate.model.effect import Effect

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def shaken(frequency, amplitude=0.05, effects: tuple[Effect, ...] = ()):
    t = np.arange(int(3.3 / frequency * 200) * 10) / 2000.0
    w = 2 * np.pi * frequency
    u, v, a = 0.25 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(LINES, t, u, v, a, 2.8, effects)[::10]
    rng = np.random.default_rng(int(10 * frequency))
    return prepare(Loop(t[::10], u[::10], force + 2e-3 * rng.standard_normal(len(force))))


@pytest.fixture(scope="module")
def drawn():
    loops = [shaken(f, a, (HubInertia(0.03),)) for f in (0.5, 1.0, 3.0) for a in (0.05, 0.02)]
    fit = fit_actuator(loops, (HubInertia,), "frequency_Hz", 1)
    return fit, loops, page(fit, loops, "ok: a title", fit.profile())


def titled(figure, word):
    return next(axes for axes in figure.axes if word in axes.get_title())


KINDS = ["measured and modelled", "by elongation", "by frequency", "residual: elongation", "residual: speed", "residual: time"]
KINDS += ["levels of the asymptotes", "slopes of the asymptotes", "stiffness by frequency", "stiffness by amplitude", "transition zone"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_of_the_papers_kind_is_on_the_page_with_units(drawn, kind):
    axes = titled(drawn[2], kind)
    for label in (axes.get_xlabel(), axes.get_ylabel()):
        assert label.endswith(")")
        assert "(" in label


def test_the_page_is_drawn_in_grey(drawn):
    for axes in drawn[2].axes:
        for line in axes.lines:
            assert len(set(to_rgb(line.get_color()))) == 1
    assert drawn[2]._suptitle.get_text() == "ok: a title"


def test_loops_side_by_side_differ_in_what_the_title_says(drawn):
    labels = {word: [line.get_label() for line in titled(drawn[2], word).lines] for word in ("by elongation", "by frequency")}
    assert {label.split(",")[0] for label in labels["by elongation"]} == {"0.5 Hz"}
    assert len(labels["by frequency"]) == 3
    assert len({label.split("stroke")[1] for label in labels["by frequency"]}) == 1


def test_marks_of_single_loops_lie_on_what_was_fitted_to_all(drawn):
    axes = titled(drawn[2], "levels of the asymptotes")
    marks = [line for line in axes.lines if line.get_label().startswith("lower") and line.get_linestyle() == "None"]
    seen = marks[0].get_ydata()
    assert np.asarray(seen) == pytest.approx(np.full(6, 2.79 - 0.25 * 0.25), abs=2e-3)


def test_the_profile_crosses_where_its_interval_ends(drawn):
    fit, _, figure = drawn
    line = titled(figure, "profile of beta").lines[0]
    low, high = fit.profile().interval
    assert np.interp([low, high], line.get_xdata(), line.get_ydata()) == pytest.approx(3.84, abs=0.1)


@pytest.mark.parametrize("loops", [[shaken(1.0)], [shaken(1.0), shaken(2.0, 0.02)]])
def test_one_loop_or_loops_without_a_partner_have_a_page_too(loops):
    figure = page(fit_actuator(loops), loops, "title")
    assert titled(figure, "measured and modelled").lines
