"""Every command line as a whole: options that a command has, drawn with odd values, on good and odd files, to good and odd outputs."""

from __future__ import annotations

import time
from importlib import import_module

import pytest
from command_server import MAINS
from fuzzing import drawn, drawn_for
from hypothesis import strategies as st
from judging import Tally, restored, tree
from odd_inputs import DESIGN, INPUTS, KEPT, NAMES, around

pytestmark = pytest.mark.xdist_group("commands")
MINUTES = 10
EXAMPLES = 8
TASKS = ("check", "effects", "fmu", "init", "completion", "run")
PARSERS = {
    **{name: (module, "_parser") for name, module in MAINS.items() if name not in ("track-video", "unspool")},
    "track-video": ("measure.commands.track_video_options", "options"),
    **{
        f"unspool {task}": (f"identify.commands.subcommands.{task}", "_parser")
        for task in ("check", "effects", "fmu", "init", "completion", "run")
    },
}
GIVEN = {  # what a command needs at least; PLACE for a file
    "track-video": ["PLACE", "--fps", "250", "--mm-per-px", "0.5", "--mark", "30,24"],
    "fit-actuator": ["PLACE"],
    "simulate-deployment": ["PLACE"],
    "sweep-deployments": ["PLACE", "--factor", "platform.mass_kg=+-1%"],
    "compare-model": ["PLACE", "PLACE"],
    "explain-gap": ["PLACE", "PLACE"],
    "design-control": ["PLACE", "--draws", "16"],
    "design-deployment": ["PLACE", *DESIGN],
    "unspool check": ["PLACE"],
    "unspool fmu": ["PLACE"],
    "unspool run": ["PLACE", "--model", "model.toml"],
}
FIRST = {"track-video": "film.avi", "fit-actuator": "loop.csv", "unspool check": "loop.csv", "unspool run": "campaign.toml"}
LISTED = ("test.csv", "loop.csv")  # in campaign.toml
LONG = {"--runs", "--draws", "--evaluations", "--workers", "--dask", "--budget"}  # these may ask for hours, which is no fault
WORDS = (
    *("", "-1", "0", "1", "2", "nan", "inf", "1e999", "1_0", "0x1", "1,2", "1,2,3", "30,24", "0,0,9,9,1", "1e9", "1e-300", "9" * 20, "200"),
    *("platform.mass_kg=1", "platform.mass_kg=+-5%", "actuator.b_l_N[0]=3", "x=", "=", "beta_per_m=1..2", "beta_per_m", "hub-inertia"),
    *("hub-inertia.mass_kg=0.1", "force=kN", "\x1b[2J", "\udce9", "é", "a" * 300, "--", "-", "$\\frac", "../x", "z_m", "sobol"),
)  # fmt: skip
PLACES = (*INPUTS, *INPUTS, "hard.csv", "soft.csv", "loop", "sub", "pipe", "nothing", "", ".", "/dev/zero", "\x1b[2J.csv", "\udce9.csv")


def options_of(name):
    """The options that a command has, as its own parser knows them."""
    module, function = PARSERS[name]
    parser = getattr(import_module(module), function)()
    return [action for action in parser._actions if action.option_strings and not {"--help", "--version"} & set(action.option_strings)]


def value_of(action):
    """What may be written behind an option."""
    known = [str(choice) for choice in action.choices or ()]
    drawn_from = [st.sampled_from(known)] * 3 if known else []
    return st.one_of(*drawn_from, st.sampled_from(WORDS), st.sampled_from(NAMES), st.sampled_from(PLACES))


@st.composite
def lines(draw):
    """A command line, and the files that it reads."""
    name = draw(st.sampled_from(sorted(PARSERS)))
    first = iter([FIRST.get(name, "rig.toml" if name.startswith("design-") else "model.toml"), "test.csv"])
    words = [draw(st.one_of(st.just(next(first)), st.sampled_from(PLACES))) if word == "PLACE" else word for word in GIVEN.get(name, [])]
    for action in draw(st.lists(st.sampled_from(options_of(name)), max_size=4)):
        option = draw(st.sampled_from(action.option_strings))
        if option in LONG:
            continue
        words.append(option)
        count = action.nargs if isinstance(action.nargs, int) else 1
        words += [draw(value_of(action)) for _ in range(count)]
    read = [place for place, word in zip(words, GIVEN.get(name, [])) if word == "PLACE"]  # noqa: B905
    return [*name.split(), *words], read


def check_of(commands, bench, tally):
    """Runs one command line and looks at what it leaves."""
    good = tree(bench)

    def check(line):
        words, read = line
        around(bench)
        before = len(tally.wrong)
        named = {*KEPT, *read, *(LISTED if "campaign.toml" in read else ())}
        inputs = [bench / name for name in named if name in INPUTS]
        tally.judge(commands, bench, words, inputs)
        restored(bench, good)
        assert len(tally.wrong) == before, tally.wrong[before:]

    return check


@pytest.mark.parametrize("seed", [1])
def test_a_drawn_command_line_ends_in_a_result_or_a_sentence(commands, bench, seed):
    drawn(lines(), check_of(commands, bench, Tally()), EXAMPLES, seed)


@pytest.mark.calibrate
def test_ten_minutes_of_drawn_command_lines_end_in_results_or_sentences(commands, bench, share_of, calibration_seed, validation_table):
    tally, begun = Tally(), time.monotonic()
    try:
        drawn_for(lines(), check_of(commands, bench, tally), share_of(60 * MINUTES), calibration_seed)
    finally:
        row = {"in minutes": (time.monotonic() - begun) / 60, **tally.row("command lines")}
        validation_table("Drawn command lines", [row], "All that stands between tries and refused is to be 0.")
