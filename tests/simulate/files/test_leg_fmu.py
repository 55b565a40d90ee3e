"""The FMU of a leg gives the force of the law, in a tool that knows nothing of this project, and goes back to where it was."""

import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest

from identify.commands.unspool import main
from measure.common.errors import InputError
from simulate import effects
from simulate.files.leg_fmu import write_fmu
from simulate.files.model_file import write_model
from simulate.law import restoring_force
from simulate.loop import loop_force
from simulate.model.measures import unit_of

# An importer in a process of its own; every output once straight on, and from the middle on once more after its state was brought back.
IMPORTER = """
import json, sys
import fmpy, numpy as np
from fmpy.fmi3 import FMU3Slave
fmu, driven = sys.argv[1:]
told = json.load(open(driven))
about = fmpy.read_model_description(fmu, validate=True)
place = {v.name: v.valueReference for v in about.modelVariables}
folder = fmpy.extract(fmu)
slave = FMU3Slave(guid=about.guid, unzipDirectory=folder, modelIdentifier=about.coSimulation.modelIdentifier, instanceName="leg")
slave.instantiate()
for name, value in told["set"].items():
    slave.setFloat64([place[name]], [value])
inputs = [place["u_m"], place["speed_m_per_s"]]
slave.enterInitializationMode()
slave.setFloat64(inputs, [told["u"][0], told["v"][0]])
slave.exitInitializationMode()
force = [slave.getFloat64([place["force_N"]])[0]]
def step(k):
    slave.setFloat64(inputs, [told["u"][k], told["v"][k]])
    slave.doStep(told["t"][k - 1], told["t"][k] - told["t"][k - 1])
    return slave.getFloat64([place["force_N"]])[0]
middle = len(told["t"]) // 2
for k in range(1, len(told["t"])):
    if k == middle:
        state = slave.getFMUState()
        kept = slave.serializeFMUState(state)
    force.append(step(k))
slave.setFMUState(state)
again = [step(k) for k in range(middle, len(told["t"]))]
slave.setFMUState(slave.deserializeFMUState(kept))
once_more = [step(k) for k in range(middle, len(told["t"]))]
print(json.dumps({"force": force, "again": again, "once_more": once_more, "middle": middle}))
"""
LAW = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
START_N = 2.8


@pytest.fixture
def model(prototype):
    a_l, b_l, a_u, b_u, beta = map(float, LAW)
    law = replace(prototype.actuator, a_l_N_per_m=a_l, b_l_N=b_l, a_u_N_per_m=a_u, b_u_N=b_u, beta_per_m=beta, initial_force_N=START_N)
    return replace(prototype, actuator=law, effects=())


def driven(fmu, t, u, v, **parameters):
    """The forces of the FMU along a motion, in an importer of its own."""
    told = fmu.with_suffix(".json")
    told.write_text(json.dumps({"t": list(t), "u": list(u), "v": list(v), "set": parameters}))
    ran = subprocess.run([sys.executable, "-c", IMPORTER, str(fmu), str(told)], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return {key: np.array(value) for key, value in json.loads(ran.stdout.splitlines()[-1]).items()}


T = np.linspace(0.0, 2.5, 501)
U = 0.05 + 0.03 * np.sin(2 * np.pi * T)  # a turning point at every 50th sample
V = 0.06 * np.pi * np.cos(2 * np.pi * T)


def test_along_a_driven_loop_the_force_is_that_of_the_law_and_a_state_brought_back_goes_the_same_way(model, tmp_path):
    write_fmu(model, tmp_path / "leg.fmu")
    found = driven(tmp_path / "leg.fmu", T, U, 0 * V)
    assert found["force"] == pytest.approx(loop_force(LAW, T, U, V, 0 * V, START_N), abs=1e-9)
    middle = int(found["middle"])
    np.testing.assert_array_equal(found["again"], found["force"][middle:])
    np.testing.assert_array_equal(found["once_more"], found["force"][middle:])


def test_a_speed_lets_the_leg_turn_within_a_step(model, tmp_path):
    """Steps of a twentieth of a period that never end at a turning point: the force there is known from the law itself."""
    write_fmu(model, tmp_path / "leg.fmu")
    fine = np.linspace(0.03, 2.03, 40001)
    shown = slice(None, None, 1000)
    elongation, speed = 0.05 + 0.03 * np.sin(2 * np.pi * fine), 0.06 * np.pi * np.cos(2 * np.pi * fine)
    true = loop_force(LAW, fine, elongation, speed, 0 * speed, START_N)[shown]
    with_speed = driven(tmp_path / "leg.fmu", fine[shown], elongation[shown], speed[shown])["force"]
    without = driven(tmp_path / "leg.fmu", fine[shown], elongation[shown], 0 * speed[shown])["force"]
    assert np.abs(with_speed - true).max() < 1e-3 * np.ptp(true)
    assert np.abs(without - true).max() > 20 * np.abs(with_speed - true).max()


def test_parameters_can_be_set_by_the_tool(model, tmp_path):
    write_fmu(model, tmp_path / "leg.fmu")
    found = driven(tmp_path / "leg.fmu", [0.0, 1.0], [0.1, 0.12], [0.0, 0.0], b_l_N=2.0, initial_force_N=2.5, beta_per_m=50.0)
    assert found["force"] == pytest.approx([2.5, float(restoring_force(0.12, 0.1, 2.5, -0.25, 2.0, 50.0))], abs=1e-12)


def test_the_same_model_gives_the_same_bytes_and_an_fmu_that_validates(model, tmp_path):
    for name in ("a.fmu", "b.fmu"):
        write_fmu(model, tmp_path / name)
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    about = fmpy.read_model_description(str(tmp_path / "a.fmu"), validate=True)
    assert about.coSimulation is not None
    assert about.coSimulation.canGetAndSetFMUstate
    assert about.coSimulation.canSerializeFMUstate
    units = {v.name: v.unit for v in about.modelVariables}
    assert (units["u_m"], units["speed_m_per_s"], units["force_N"], units["beta_per_m"]) == ("m", "m/s", "N", "1/m")


def test_each_unit_is_made_of_the_base_units_that_the_name_of_its_variable_says(model, tmp_path):
    write_fmu(model, tmp_path / "leg.fmu")
    about = fmpy.read_model_description(str(tmp_path / "leg.fmu"))
    base = {unit.name: unit.baseUnit for unit in about.unitDefinitions}
    checked = set()
    for variable in about.modelVariables:
        if variable.unit and "_" in variable.name:
            force, length, time, mass = unit_of(variable.name)
            made = base[variable.unit]
            assert made is not None
            assert (made.kg, made.m, made.s) == (mass + force, length + force, time - 2 * force), variable.name
            checked.add(variable.unit)
    assert checked == {"m", "m/s", "N", "N/m", "1/m"}


def test_legs_that_differ_must_be_named(model, tmp_path):
    uneven = replace(model, actuator=replace(model.actuator, b_l_N=(2.7, 2.71, 2.72, 2.73, 2.74, 2.75)))
    with pytest.raises(InputError, match=r"the legs differ in b_l_N\. Name one with --leg 1"):
        write_fmu(uneven, tmp_path / "leg.fmu")
    write_fmu(uneven, tmp_path / "leg.fmu", 3)
    with zipfile.ZipFile(tmp_path / "leg.fmu") as packed:
        assert json.loads(packed.read("resources/law.json"))["parameters"]["b_l_N"][0] == 2.72


def test_an_effect_on_the_law_is_refused_and_one_beside_it_is_named(model, tmp_path, capsys):
    write_model(model.with_effect(effects.HubInertia(mass_kg=0.03)), tmp_path / "rig.toml")
    assert main(["fmu", str(tmp_path / "rig.toml"), "-o", str(tmp_path / "leg.fmu")]) == 0
    assert "without hub-inertia (0.03): add that in your tool" in capsys.readouterr().out
    write_model(model.with_effect(effects.CurvedAsymptotes(quadratic_N_per_m2=0.5)), tmp_path / "bent.toml")
    assert main(["fmu", str(tmp_path / "bent.toml"), "-o", str(tmp_path / "bent.fmu")]) == 2
    assert "curved-asymptotes changes the asymptotes" in capsys.readouterr().err
    assert not (tmp_path / "bent.fmu").exists()


def test_without_the_extra_or_with_another_ending_it_is_refused(model, tmp_path, monkeypatch, capsys):
    with pytest.raises(InputError, match=r"ends in \.fmu"):
        write_fmu(model, Path(tmp_path) / "leg.zip")
    monkeypatch.setitem(sys.modules, "pythonfmu3", None)
    write_model(model, tmp_path / "rig.toml")
    assert main(["fmu", str(tmp_path / "rig.toml"), "-o", str(tmp_path / "leg.fmu")]) == 2
    assert 'pip install "unspool[fmu]"' in capsys.readouterr().err
