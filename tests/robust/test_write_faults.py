"""Every act of writing of every command fails once: a full disk, no permission, a kill, a file that cannot grow. What is left is looked at.

After a refusal all is as before; after a kill each result is the old or the new one, whole, and the next run gives what an undisturbed
one gives, with nothing left over.
"""

from __future__ import annotations

import random

import pytest
from command_server import REMOVING
from judging import restored, tree
from odd_inputs import DESIGN, TRACK

pytestmark = pytest.mark.xdist_group("commands")
COMMANDS = {
    "track-video": [*TRACK, *("-o", "out.csv", "--marks", "marks.csv", "--json", "out.json", "--pictures", "outs", "--overlay", "out.avi")],
    "fit-actuator": [
        "fit-actuator",
        "loop.csv",
        "--no-suggest",
        *("-o", "out.toml", "--json", "out.json", "--figure", "out.png", "--save-mapping", "m.toml"),
    ],
    "simulate-deployment": [
        *("simulate-deployment", "model.toml", "-o", "out.csv", "--json", "out.json", "--legs", "legs.csv", "--energy", "energy.csv"),
        *("--mjcf", "out.xml", "--page", "out.html", "--figure", "out.png"),
    ],
    "sweep-deployments": ["sweep-deployments", "model.toml", "--factor", "platform.mass_kg=+-1%", "-o", "outs", "--json", "out.json"],
    "compare-model": ["compare-model", "model.toml", "test.csv", "-o", "out.png", "--json", "out.json"],
    "explain-gap": ["explain-gap", "model.toml", "test.csv", "-o", "outs", "--json", "out.json"],
    "design-control": ["design-control", "rig.toml", "--draws", "16", "-o", "out.toml", "--json", "out.json", "--page", "out.html"],
    "design-deployment": ["design-deployment", "rig.toml", *DESIGN, "-o", "out.toml", "--json", "out.json"],
    "unspool init": ["unspool", "init", "outs"],
    "unspool run": ["unspool", "run", "films.toml", "--model", "rig.toml", "-o", "outs", "--json", "out.json"],
}
NEVER_OVER_OLD = ("unspool init",)  # templates are never written over
STEP_BY_STEP = ("unspool run",)  # it types the other commands: what those before the fault have written stands
MOST = 1000  # acts of writing that fail in each way; a command has fewer
FAULTS = ("full", "denied", "kill", "small")
KEY, PIECES = b".unspool-", b"outs.part"  # the pieces of a sweep stay whatever happens, for --resume


def places(how, acts, results, chance, most):
    """Which acts go wrong; of a file that cannot grow, how many bytes it may have."""
    if how == "small":
        sizes = sorted(
            {size for content in results.values() if isinstance(content, bytes) for size in (len(content) // 2, len(content) - 1)}
        )
        return [{"largest_file": size} for size in chance.sample(sizes, min(most, len(sizes)))]
    able = [k for k, act in enumerate(acts) if how == "kill" or not act.startswith(REMOVING)]
    return [{"fault": {"at": k, "how": how}} for k in sorted(chance.sample(able, min(most, len(able))))]


def undisturbed(commands, bench, name):
    """The acts of writing of a command, and the folder with its results."""
    ended = commands.run(COMMANDS[name], bench, fault={"folder": str(bench), "at": -1, "how": "kill"})
    assert ended.status in (0, 1), ended
    return ended.events, tree(bench)


def look(commands, bench, name, hows, most, chance):
    """Let acts of writing fail; how many, and sentences on what was wrong afterwards."""
    before = tree(bench)
    acts, whole = undisturbed(commands, bench, name)
    results = {path: content for path, content in whole.items() if path not in before}
    tries, wrong = 0, []
    for how in hows:
        for place in places(how, acts, results, chance, most):
            tries += 1
            restored(bench, before)
            lay_old(bench, {} if name in NEVER_OVER_OLD else results)
            old = tree(bench)
            given = {kind: {"folder": str(bench), **what} if kind == "fault" else what for kind, what in place.items()}
            ended = commands.run(COMMANDS[name], bench, **given)
            found = found_wrong(ended, how, old, tree(bench), whole, name in STEP_BY_STEP)
            if how == "kill" and name not in NEVER_OVER_OLD:
                again = commands.run(COMMANDS[name], bench)
                found += [f"the next run: {again.status} {again.error!r}"] * (again.status not in (0, 1))
                found += ["the next run has other results"] * (tree(bench) != whole)
            wrong += [f"{name}, {how}, {place}, {acts[place['fault']['at']] if 'fault' in place else ''}: {text}" for text in found]
    restored(bench, before)
    return tries, wrong


def lay_old(bench, results):
    """Old results under the names of those that are written."""
    for path, content in results.items():
        if isinstance(content, bytes):
            (bench / path.decode()).parent.mkdir(exist_ok=True)
            (bench / path.decode()).write_bytes(b"old")


def found_wrong(ended, how, old, left, whole, step_by_step):
    """What may not be after a fault."""
    if how == "kill":
        return half_written(old, {path: content for path, content in left.items() if KEY not in path}, whole)
    if ended.status in (0, 1):
        return [] if left == whole else ["done, but the results are not those of an undisturbed run"]
    said = [] if ended.status == 2 and ended.error.strip() else [f"status {ended.status}, {ended.error[-300:]!r}"]
    if step_by_step:
        return said + half_written(old, left, whole)
    changed = sorted(path for path in {*left, *old} if left.get(path) != old.get(path) and PIECES not in path)
    return said + [f"left or changed: {changed}"] * bool(changed)


def half_written(old, left, whole):
    """What is neither as before nor as in the end, and what is gone."""
    half = [path for path, content in left.items() if content not in (old.get(path), whole.get(path)) and PIECES not in path]
    return [f"half written: {half}"] * bool(half) + ["lost"] * (not set(old) <= set(left))


@pytest.mark.parametrize(("name", "how"), [*zip(sorted(COMMANDS), FAULTS * 3, strict=False)])
def test_a_write_that_fails_leaves_everything_as_it_was(commands, bench, name, how):
    assert look(commands, bench, name, [how], 1, random.Random(name)) == (1, [])


@pytest.mark.calibrate
@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_whichever_write_fails_everything_is_left_as_it_was(commands, bench, name, share_of, calibration_seed, validation_table):
    chance = random.Random(f"{name} {calibration_seed}")
    tries, wrong = look(commands, bench, name, FAULTS, share_of(MOST), chance)
    row = {"command": name, "acts that failed": tries, "wrong afterwards": len(wrong)}
    validation_table("Failing writes", [row], "A full disk, no permission, a file that cannot grow, a kill: at any act of writing.")
    assert not wrong, "\n".join(wrong)
