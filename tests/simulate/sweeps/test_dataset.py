"""A sweep as HDF5 and netCDF: every number, unit and level arrives, and the same sweep gives the same bytes."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray

from measure.common.errors import InputError
from measure.common.limits import DATASET_ENDINGS
from measure.tables.dataset_file import Variable, write_dataset
from simulate import Simulation, sweep, write_sweep
from simulate.commands import sweep_deployments
from simulate.files.model_file import write_model

FACTORS = ["actuator.stored_force_N[0]=+-10%", "platform.mass_kg=sigma:0.02"]


@pytest.fixture(scope="module")
def model(prototype_once):
    return replace(prototype_once, name="Gerät 3", simulation=Simulation(0.2, 500.0))


@pytest.fixture(scope="module")
def result(model):
    return sweep(model, FACTORS, "random", runs=40, seed=2**63 - 1)


def hdf5(path):
    """Variables, their attributes and those of the file."""
    with h5py.File(path) as file:
        values = {name: item.asstr()[()] if item.dtype.kind == "O" else item[()] for name, item in file.items()}
        dimensions = {name: item.dims[0][0].name for name, item in file.items() if name not in ("run", "term")}
        assert dimensions["theta_z_deg"] == "/run"
        assert dimensions["coefficient"] == "/term"
        return values, {name: dict(item.attrs) for name, item in file.items()}, dict(file.attrs)


def netcdf(path):
    with xarray.open_dataset(path, engine="scipy") as data:
        assert data["theta_z_deg"].dims == ("run",)
        return {name: item.values for name, item in data.variables.items()}, {n: i.attrs for n, i in data.variables.items()}, data.attrs


READ = {".h5": hdf5, ".nc": netcdf}
every_ending = pytest.mark.parametrize("ending", DATASET_ENDINGS)


@every_ending
def test_every_run_and_coefficient_arrives_with_its_unit(result, tmp_path, ending):
    write_sweep(result, tmp_path / f"s{ending}", {"command": "sweep"})
    values, attributes, whole = READ[ending](tmp_path / f"s{ending}")
    runs, terms = result.to_frame(), result.to_frame("coefficients")
    for name in runs.columns:
        np.testing.assert_array_equal(values[name], runs[name].to_numpy(), err_msg=name)
    np.testing.assert_array_equal(values["coefficient"], terms["coefficient_deg"].to_numpy())
    assert list(values["term_name"]) == list(terms["name"])
    assert attributes["stop_force_N"]["units"] == "N"
    assert attributes["coefficient"]["units"] == "deg"
    assert (whole["model"], whole["design"], whole["seed"]) == ("Gerät 3", "random", str(2**63 - 1))
    assert json.loads(whole["provenance"]) == {"command": "sweep"}


@every_ending
def test_the_value_of_a_factor_stands_beside_its_coded_level(result, tmp_path, ending):
    write_sweep(result, tmp_path / f"s{ending}")
    values, attributes, whole = READ[ending](tmp_path / f"s{ending}")
    about = attributes["B_value"]
    assert (about["key"], about["units"], attributes["A_value"]["units"]) == ("platform.mass_kg", "kg", "N")
    middle = (about["low"] + about["high"]) / 2
    np.testing.assert_allclose(values["B_value"], middle + 0.02 * values["B"], rtol=1e-12)
    assert about["spread"].startswith("normal")
    assert "provenance" not in whole


@every_ending
def test_the_command_writes_one_file_and_twice_the_same_bytes(model, tmp_path, ending, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_model(model, tmp_path / "rig.toml")
    words = ["rig.toml", "--design", "random", "--runs", "40", "--seed", "3", "--quiet", "-o", f"s{ending}"]
    made = []
    for workers in ("1", "2"):
        assert sweep_deployments.main([*words, "--factor", FACTORS[0], "--workers", workers]) == 0
        assert sorted(path.name for path in tmp_path.iterdir()) == ["rig.toml", f"s{ending}"]
        made.append((tmp_path / f"s{ending}").read_bytes())
    assert made[0] == made[1]
    _, _, whole = READ[ending](tmp_path / f"s{ending}")
    assert json.loads(whole["provenance"])["seed"] == 3


def test_hdf5_without_its_library_is_refused_before_any_run(model, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    write_model(model, tmp_path / "rig.toml")
    assert sweep_deployments.main([str(tmp_path / "rig.toml"), "-o", str(tmp_path / "s.h5")]) == 2
    assert 'pip install "unspool[hdf5]"' in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["rig.toml"]


@every_ending
def test_a_file_that_cannot_be_finished_leaves_the_old_one(tmp_path, ending):
    path = tmp_path / f"s{ending}"
    path.write_text("old")

    def broken():
        yield 1.0
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError):
        write_dataset(path, {"run": 2}, {"x": Variable("run", broken())})
    assert path.read_text() == "old"
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_another_ending_is_refused(result, tmp_path):
    with pytest.raises(InputError, match=r"ends in \.h5 or \.nc"):
        write_sweep(result, tmp_path / "s.hdf")
