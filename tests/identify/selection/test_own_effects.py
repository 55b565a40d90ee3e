"""An effect of one's own, in a file of one's own, goes the whole way: fitted, named, written, simulated, swept."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from identify.commands import compare_model, explain_gap, fit_actuator
from simulate.commands import simulate_deployment, sweep_deployments
from simulate.files.own_effects import catalogue_with
from simulate.model.effect import Effect

SPRING = """
from dataclasses import dataclass

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class ReturnSpring(LegEffect):
    name = "return-spring"
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=500.0, typical=1.0, doc="pulls the strip back where it has curled")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return -p[0] * u * abs(u)
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.py"
    path.write_text(SPRING)
    return path


def spring(file: Path, stiffness: float) -> Effect:
    return catalogue_with([file])["return-spring"](stiffness_N_per_m=stiffness)  # type: ignore[call-arg]


@pytest.mark.slow
def test_an_effect_of_ones_own_is_named_and_its_model_is_accepted_by_every_command(campaign, file, tmp_path, capsys):
    folder = campaign(spring(file, 20.0), 651, deployments=(), loops=((0.2, 0.04), (1.0, 0.04)))
    own, out = ["--effects", str(file)], tmp_path / "out"
    loops = sorted(map(str, folder.glob("loop-*.csv")))
    assert explain_gap.main([str(folder / "model.toml"), *loops, *own, "-o", str(out), "--quiet"]) == 0
    result = json.loads((out / "result.json").read_text())
    assert "return-spring" in [name for found in result["effects"] for name in (found["name"], *found["equivalents"])]
    assert str(file) in json.dumps(result["provenance"])
    model = out / "extended.toml"
    assert "return-spring" in [effect["name"] for effect in tomllib.loads(model.read_text())["effect"]]

    deployment = str(tmp_path / "deployment.csv")
    assert simulate_deployment.main([str(model), *own, "-o", deployment, "--quiet"]) == 0
    assert compare_model.main([str(model), deployment, *loops, *own, "--quiet"]) == 0
    factor = ["--factor", "effect.return-spring.stiffness_N_per_m=+-10%", "--factor", "actuator.stored_force_N[0]=+-10%"]
    assert sweep_deployments.main([str(model), *own, *factor, "-o", str(tmp_path / "sweep"), "--quiet"]) == 0
    capsys.readouterr()
    assert simulate_deployment.main([str(model), "-o", str(tmp_path / "none.csv")]) == 2
    assert 'no effect is named "return-spring"' in capsys.readouterr().err
    assert not (tmp_path / "none.csv").exists()


def test_an_effect_of_ones_own_is_fitted_to_loops(campaign, file, tmp_path):
    folder = campaign(spring(file, 20.0), 652, deployments=(), loops=((0.2, 0.04), (1.0, 0.04), (3.0, 0.04)))
    loops = sorted(map(str, folder.glob("loop-*.csv")))
    result = tmp_path / "fit.json"
    effects = [word for name in ("hub-inertia", "viscous-friction", "return-spring") for word in ("--effect", name)]
    assert fit_actuator.main([*loops, "--effects", str(file), *effects, "--no-suggest", "--json", str(result), "--quiet"]) == 0
    found = json.loads(result.read_text())["parameters"]["return-spring.stiffness_N_per_m"]
    assert found["ci95"][0] < 20.0 < found["ci95"][1]
    assert found["value"] == pytest.approx(20.0, rel=0.1)


def test_an_effect_of_ones_own_can_be_set_in_a_model_that_has_it_not(file, prototype, tmp_path):
    from simulate.files.model_file import write_model

    write_model(replace(prototype, effects=()), tmp_path / "model.toml")
    heights = []
    for stiffness in ("0.0", "5.0"):
        setting = ["--set", f"effect.return-spring.stiffness_N_per_m={stiffness}", "--effects", str(file), "--quiet"]
        written = ["-o", str(tmp_path / "d.csv"), "--json", str(tmp_path / "d.json")]
        assert simulate_deployment.main([str(tmp_path / "model.toml"), *setting, *written]) == 0
        heights.append(json.loads((tmp_path / "d.json").read_text())["time_to_full_height_s"])
    assert heights[1] > heights[0], "a spring that pulls back makes a slower rise"


def test_pieces_of_a_sweep_with_another_formula_are_not_taken_up(file, prototype, tmp_path):
    """The same name and numbers, and another formula in the file: what stands on disk says nothing about it."""
    from simulate.sweeps.chunks import key_of
    from simulate.sweeps.designs import design_of
    from simulate.sweeps.factors import factors_of
    from simulate.sweeps.sweep import Sweep

    keys = []
    for formula in ("u * abs(u)", "u"):
        other = tmp_path / f"mine-{len(keys)}.py"
        other.write_text(SPRING.replace("u * abs(u)", formula))
        model = prototype.with_effect(spring(other, 5.0))
        factors = tuple(factors_of(model, ["actuator.stored_force_N[0]=+-10%"]))
        keys.append(key_of(Sweep(model, factors, design_of("full", 1, None, 0, []))))
    assert keys[0] != keys[1]


def test_a_cluster_is_refused_for_effects_that_its_workers_have_not_got(file, tmp_path, capsys):
    model = Path(__file__).resolve().parents[1].joinpath("rig.toml")
    words = [str(model), "--effects", str(file), "--dask", "tcp://127.0.0.1:1", "-o", str(tmp_path / "sweep")]
    assert sweep_deployments.main(words) == 2
    assert "sweep without --dask" in capsys.readouterr().err
    assert not list(tmp_path.glob("sweep*"))


def test_files_that_define_no_effect_are_refused(tmp_path, capsys):
    empty = tmp_path / "empty.py"
    empty.write_text("x = 1\n")
    model = Path(__file__).resolve().parents[1].joinpath("rig.toml")
    assert simulate_deployment.main([str(model), "--effects", str(empty), "-o", str(tmp_path / "d.csv")]) == 2
    assert f"{empty}: defines no effect" in capsys.readouterr().err
