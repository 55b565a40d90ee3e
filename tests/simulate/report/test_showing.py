"""What a notebook shows of a deployment and of a sweep."""

from dataclasses import replace

from simulate import deploy, sweep
from simulate.model.model import Simulation


def _looks_right(result):
    assert len(repr(result)) < 300
    shown = result._repr_html_()
    assert "<table" in shown
    assert "data:image/png;base64," in shown


def test_a_deployment_shows_itself(lopsided):
    run = deploy(replace(lopsided, simulation=Simulation(0.2, 500.0)))
    _looks_right(run)
    assert [axes.get_ylabel() for axes in run.plot().axes][:1] == ["elevation, mm"]


def test_a_sweep_shows_its_coefficients_and_responses(lopsided):
    result = sweep(replace(lopsided, simulation=Simulation(0.1, 500.0)), ["platform.mass_kg=+-1%", "platform.inertia_kg_m2[2]=+-5%"])
    _looks_right(result)
    assert "of 3 coefficients" in result.plot().axes[0].get_title()
