"""Files, values, tables and outputs that nobody means well, tried on every command.

Each try ends with 0, 1 or 2, soon, in a sentence where it is refused; then nothing has been written, and no input is lost.
`make calibrate` makes as many tries of each kind as the table in docs/validation says; a few are made each time.
"""

from __future__ import annotations

import shutil
import tomllib

import pytest
import tomli_w
from judging import Tally, chances, counts, restored, tree
from odd_inputs import ENTRIES, NAMES, OUTPUTS, around, hostile, mutated, mutated_table, read_by

pytestmark = pytest.mark.xdist_group("commands")
TITLE = "Files, values, tables and outputs that nobody means well"
NOTE = "What stands between tries and refused is to be 0. A refusal may take 5 s of processor time, and 300 MB beside what is loaded."


@pytest.fixture
def tally(request, validation_table):
    """Counts of one kind of tries; the test ends by asking for its end."""
    kind = request.node.originalname.removeprefix("test_").replace("_", " ")
    keep = request.node.get_closest_marker("calibrate") is not None
    return Tally(at_end=lambda counted: validation_table(TITLE, [counted.row(kind)], NOTE) if keep else None)


@pytest.mark.parametrize(("full", "seed"), counts(26 * len(ENTRIES)))
def test_a_hostile_file_ends_in_a_sentence(commands, bench, tally, full, seed, share_of, calibration_seed):
    for chance in chances("files", full, seed, share_of, calibration_seed):
        path = hostile(chance, bench)
        words = [path.name if word == "HERE" else word for word in ENTRIES[chance.choice(sorted(ENTRIES))]]
        tally.judge(commands, bench, words)
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    tally.end()


@pytest.mark.parametrize(("full", "seed"), counts(82))
def test_an_odd_model_ends_in_a_sentence_or_a_result(commands, bench, tally, full, seed, share_of, calibration_seed):
    model = (bench / "model.toml").read_text()
    path = bench / "odd.toml"
    for chance in chances("models", full, seed, share_of, calibration_seed):
        path.write_text(tomli_w.dumps(mutated(chance, tomllib.loads(model))))
        words = chance.choice(
            [
                ["simulate-deployment", "odd.toml", "-o", "out.csv", "--figure", "out.png"],
                ["compare-model", "odd.toml", "test.csv", "--json", "out.json"],
                ["sweep-deployments", "odd.toml", "--factor", "platform.mass_kg=+-1%", "-o", "out"],
                ["design-control", "odd.toml", "--draws", "16", "-o", "out.toml"],
            ]
        )
        tally.judge(commands, bench, words, [path, bench / "test.csv"])
    tally.end()


@pytest.mark.parametrize(("full", "seed"), counts(99))
def test_an_odd_campaign_ends_in_a_sentence_or_a_result(commands, bench, tally, full, seed, share_of, calibration_seed):
    campaign = tomllib.loads((bench / "campaign.toml").read_text())
    campaign["run"][0]["model"] = {"platform": {"mass_kg": 1.0}, "nuisance": {"release_position_m": 1e-3}}
    path, text = bench / "odd.toml", tomli_w.dumps(campaign)
    for chance in chances("campaigns", full, seed, share_of, calibration_seed):
        path.write_text(tomli_w.dumps(mutated(chance, tomllib.loads(text))))
        command = chance.choice([["compare-model", "-o", "out.png"], ["compare-model", "--json", "out.json"], ["explain-gap", "-o", "out"]])
        tally.judge(commands, bench, [command[0], "model.toml", "odd.toml", *command[1:]], [path, bench / "test.csv", bench / "loop.csv"])
    tally.end()


@pytest.mark.parametrize(("full", "seed"), counts(396))
def test_an_odd_table_ends_in_a_sentence_or_a_result(commands, bench, tally, full, seed, share_of, calibration_seed):
    tables = {name: (bench / name).read_text() for name in ("loop.csv", "test.csv")}
    path = bench / "odd.csv"
    for chance in chances("tables", full, seed, share_of, calibration_seed):
        name = chance.choice(sorted(tables))
        path.write_text(mutated_table(chance, tables[name]))
        words = ["compare-model", "model.toml", "odd.csv", "--json", "out.json"]
        if name == "loop.csv" and chance.random() < 0.7:
            words = ["fit-actuator", "odd.csv", "-o", "out.toml", "--json", "out.json"]
        tally.judge(commands, bench, words, [path])
    tally.end()


@pytest.mark.parametrize(("full", "seed"), counts(48 * len(OUTPUTS)))
def test_no_output_takes_the_place_of_an_input_or_is_left_behind_by_a_refusal(
    commands, bench, tally, full, seed, share_of, calibration_seed
):
    good = tree(bench)
    for chance in chances("outputs", full, seed, share_of, calibration_seed):
        around(bench)
        words, more = OUTPUTS[chance.choice(sorted(OUTPUTS))]
        given = {"-o": chance.choice(NAMES), **{option: chance.choice(NAMES) for option in more if chance.random() < 0.4}}
        inputs = [*read_by(bench, words), bench / "sw.part" / "mine.txt"]
        tally.judge(commands, bench, [*words, *(word for pair in given.items() for word in pair)], inputs)
        restored(bench, good)
    tally.end()
