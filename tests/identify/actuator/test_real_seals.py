"""A pneumatic seal's friction, measured by others: what its law alone misses is the supply pressure, and no effect is made of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from identify.commands import explain_gap, fit_actuator
from simulate.effects import CATALOGUE

REAL = Path(__file__).resolve().parents[3].parent / "shared" / "real" / "loops" / "pneumatic-seal"
COLUMNS = [
    word
    for key, place, unit in (("time", 1, "ms"), ("elongation", 5, "mm"), ("force", 7, "N"))
    for word in ("--column", f"{key}={place}", "--unit", f"{key}={unit}")
]
BY_RATE = {name for name in CATALOGUE if "friction" in name or "rate" in name or name in ("force-relaxation", "sensor-lag")}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """The law of all files of one seal, as a model file, and these files."""
    if not REAL.is_dir():
        pytest.skip(f"real loops are not there: {REAL}")
    files = [str(path) for path in sorted(REAL.glob("KDN_*.csv"))]
    model = tmp_path_factory.mktemp("seal") / "model.toml"
    fit_actuator.main([*files, *COLUMNS, "-o", str(model), "--json", str(model.with_suffix(".json")), "--quiet"])
    return str(model), files


def explained(campaign, folder, *words):
    model, files = campaign
    status = explain_gap.main([model, *files, *COLUMNS, *words, "-o", str(folder), "--quiet"])
    result = json.loads((folder / "result.json").read_text())
    assert status == (1 if result["verdict"] == "unknown" else 0)
    return result


@pytest.mark.calibrate
def test_no_friction_is_made_of_a_real_seals_supply_pressure_and_its_column_is_pointed_at(campaign, tmp_path):
    result = explained(campaign, tmp_path)
    assert not {finding["name"] for finding in result["effects"]} & BY_RATE
    assert result["verdict"] == "unknown"
    assert '"column 6"' in result["missing_force"].partition("; --covariate")[0]  # column 3 is the same pressure in volts


@pytest.mark.calibrate
def test_with_the_pressure_as_covariate_nearly_all_of_a_real_seals_gap_goes_and_nothing_is_named(campaign, tmp_path):
    result = explained(campaign, tmp_path, "--covariate", "column 6")
    assert not {finding["name"] for finding in result["effects"]} & BY_RATE
    assert result["gap"]["before"]["rms_over_noise"] < 0.02 * result["gap"]["as_given"]["rms_over_noise"]
