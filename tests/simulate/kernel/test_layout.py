"""The memory of the kernel: no two things stand at one place, and all stand within their rows."""

from __future__ import annotations

import pytest

from simulate.kernel import layout as at
from simulate.kernel.layout import LEGS

MODEL = {"MASS": 3, "INERTIA": 3, "WEIGHT": 3, "CENTRE": 3, "POSITION": 3, "QUATERNION": 4, "VELOCITY": 3, "ANGULAR": 3, "STOP": 3}
OF_A_LEG = {"JOINT": 3, "STOWED": 1, "FULL": 1, "LOWEST": 1, "LINE": 5, "START_FORCE": 1}
BLOCK = {
    "STATE": at.STATES, "SPENT": at.POWERS, "TRIAL": at.STATES, "RATE": at.STATES + at.POWERS, "TOTAL": at.STATES + at.POWERS,
    **dict.fromkeys(("ELONGATION", "STORED", "TURNED", "HEADING", "STRIP"), LEGS),
    "ROTATION": 9, "SYSTEM": 21, "RIGHT": 6, "KINETIC": 1, "BASE_ROW": 6, "BASE_SYSTEM": 1, "BASE_FORCE": 1,
    "LEG_VALUE": at.LEG_SIZE, "LEG_BEFORE": 4, "LENGTH": 1, "U": 1, "V": 1, "BIAS": 1, "ARM": 3, "AXIS": 3, "LEVER": 3, "H": 4,
    **dict.fromkeys(("R", "STOP_FORCE", "ADDED", "AXIAL_MASS", "G", "SLOPE", "EACH", "STRIP_NOW", "EASED", "PER_LENGTH"), 1),
    "JOINT_RATE": 2, "RESISTANCE": 2,
    **dict.fromkeys(("OUT", "OUT_V", "OUT_R", "OUT_STOP", "OUT_FORCE", "OUT_STRIP"), LEGS),
    **dict.fromkeys(("TIME", "STEP", "TIME_BEFORE", "TIME_NOW"), 1),
    "MATRIX": 36,
}  # fmt: skip
FOR_AN_EFFECT = {"SCRATCH_POSE": 7, "SCRATCH_TWIST": 6, "SCRATCH_WRENCH": 6, "SCRATCH_MATRIX": 36, "SCRATCH_PAIR": 2}
FOR_A_LAW = {"SCRATCH_U": LEGS, "SCRATCH_V": LEGS, "SCRATCH_TURN": 2, "SCRATCH_OWN": at.OWN_SIZE, "SCRATCH_OUT": LEGS}
CONTROLLER = {
    "CONTROL_AXIS": 6 * LEGS, "CONTROL_BIAS": LEGS, "CONTROL_FORCE": LEGS,
    **dict.fromkeys(("COUNTED", "CLOCK", "PEAK", "TAKEN_OUT", "POWER_BEFORE"), 1),
    **dict.fromkeys(("HELD", "LEVEL", "READ", "ESTIMATE", "SPEED", "COMMAND"), LEGS),
    "TURN": 2, **dict.fromkeys(("TRUE_TURN", "DUE", "FAILED", "HOLDS", "ARRIVAL", "EVENT"), 1),
    "OWN": at.OWN_SIZE, "OWN_NEXT": at.OWN_SIZE, "QUEUED": 1, "TAKEN": 1, "QUEUE": 7 * at.QUEUE_LENGTH,
}  # fmt: skip
SAMPLE = {
    "SAMPLE_POSE": 7, "SAMPLE_TWIST": 6, "SAMPLE_ELONGATION": LEGS, "SAMPLE_STORED": LEGS, "SAMPLE_FORCE": LEGS, "SAMPLE_ENERGY": 4,
}  # fmt: skip


@pytest.mark.parametrize(
    ("sizes", "end"),
    [
        (MODEL, at.LEG),
        (OF_A_LEG, at.LEG_SIZE),
        (BLOCK, at.ROWS),
        (FOR_AN_EFFECT, at.SCRATCH),
        (FOR_A_LAW, at.SCRATCH),
        (CONTROLLER, at.CONTROL_ROWS),
        (SAMPLE, at.SAMPLE_SIZE),
    ],
)
def test_what_stands_behind_one_another_neither_overlaps_nor_reaches_beyond_the_end(sizes, end):
    behind = 0
    for name, size in sizes.items():
        assert getattr(at, name) >= behind, name
        behind = getattr(at, name) + size
    assert behind <= end


def test_a_rigid_body_is_a_pose_and_a_twist_and_a_base_that_moves_a_height_and_a_rate():
    assert (at.RIGID, at.BASE, at.STATES) == (3 + 4 + 3 + 3, 13, 15)
    assert at.PARAMETERS == at.LEG + LEGS * at.LEG_SIZE
    assert {at.BY_LEGS, at.BY_STOPS, at.BY_WEIGHT} == set(range(1, 1 + at.POWERS))


def test_room_for_a_formula_is_a_whole_number_of_rows_whatever_the_width():
    assert all(at.SCRATCH % lanes == 0 for lanes in (at.ALONE, at.FEW, at.MANY))


def test_stages_of_heun_lie_at_thirds():
    """Third order for a polynomial: weights 1/4, 0, 3/4 at 0, 1/3, 2/3 integrate up to the square exactly."""
    assert pytest.approx(1 / 2) == 0.75 * at.SECOND_OF_THREE
    assert pytest.approx(1 / 3) == 0.75 * at.SECOND_OF_THREE**2
    assert pytest.approx(1 / 6) == at.FIRST_OF_THREE * at.SECOND_OF_THREE * 0.75
