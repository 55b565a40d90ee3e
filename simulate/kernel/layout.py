"""Where everything stands: the numbers of a model, the memory of a block of runs that are integrated side by side, and a sample.

The memory is one flat array, row after row, `lanes` numbers a row: entry i of row r is w[r * lanes + i], run i of the block. All
rows are constants, so that the compiler sees that they do not overlap and works the lanes in vector registers. What a model gives
stands in an array of its own, laid out alike. `docs/theory/kernel.md` shows the whole.
"""

from __future__ import annotations

LEGS = 6
BEYOND = 1e6  # a state outside of this has diverged
NEVER = -1e9  # elongation at the last reversal where there was none
LEAST_TRAVEL = 1e-12  # m in a step; what is less is rounding, and no direction

# The numbers of a model, one row a run; of each leg from its base joint on, LEG_SIZE in all. Parameters of effects stand behind.
MASS, INERTIA, WEIGHT, CENTRE = 0, 3, 6, 9
POSITION, QUATERNION, VELOCITY, ANGULAR = 12, 15, 19, 22
STOP = 25  # stiffness, damping, smoothing
LEG, LEG_SIZE = 28, 15
JOINT, STOWED, FULL, LOWEST, LINE, START_FORCE = 3, 6, 7, 8, 9, 14
PARAMETERS = LEG + LEGS * LEG_SIZE

# The memory of a block.
RIGID = 13  # position of the centre of mass (3), unit quaternion (4), velocity (3), angular velocity (3), world axes
BASE = RIGID  # height of the base ring over where it was at the release, and its rate
STATES = RIGID + 2
POWERS = 3  # work done so far, or its rate, by legs, stops, weight; that of effects stands behind everything else

STATE = 0
SPENT = STATE + STATES
TRIAL = SPENT + POWERS
RATE = TRIAL + STATES  # of state and work
TOTAL = RATE + STATES + POWERS
# What the legs carry from step to step, six rows each.
ELONGATION = TOTAL + STATES + POWERS
STORED = ELONGATION + LEGS
TURNED = STORED + LEGS
HEADING = TURNED + LEGS
STRIP = HEADING + LEGS
ROTATION = STRIP + LEGS
SYSTEM = ROTATION + 9  # lower half, row by row
RIGHT = SYSTEM + 21
KINETIC = RIGHT + 6
# A base ring that moves: its row of the system without and with itself, and the force on it.
BASE_ROW = KINETIC + 1
BASE_SYSTEM, BASE_FORCE = BASE_ROW + 6, BASE_ROW + 7
# The leg at hand: its parameters, where it stood at the last step, and what it does now.
LEG_VALUE = BASE_FORCE + 1
LEG_BEFORE = LEG_VALUE + LEG_SIZE  # elongation, hysteretic force, elongation at the last reversal, elongation of the strip
LENGTH = LEG_BEFORE + 4
U, V, BIAS, ARM, AXIS, LEVER = LENGTH + 1, LENGTH + 2, LENGTH + 3, LENGTH + 4, LENGTH + 7, LENGTH + 10
H = LENGTH + 13  # lower and upper asymptote before, lower and upper now
R, STOP_FORCE, ADDED, AXIAL_MASS, G, SLOPE, EACH, STRIP_NOW, EASED, PER_LENGTH = range(H + 4, H + 14)
# Angular speed of its two joints and what resists them, each at the base and at the platform.
JOINT_RATE, RESISTANCE = PER_LENGTH + 1, PER_LENGTH + 3
# What the legs do, six rows each: elongation, speed, hysteretic, stop and whole force, elongation of the strip.
OUT = RESISTANCE + 2
OUT_V, OUT_R, OUT_STOP, OUT_FORCE, OUT_STRIP = OUT + LEGS, OUT + 2 * LEGS, OUT + 3 * LEGS, OUT + 4 * LEGS, OUT + 5 * LEGS
# Time at the start of the step at hand and length of the step; when the legs stood as kept, and when they are looked at.
TIME, STEP, TIME_BEFORE, TIME_NOW = range(OUT + 6 * LEGS, OUT + 6 * LEGS + 4)
# The platform's mass matrix in full, row by row, for formulas that change it in all runs at once.
MATRIX = TIME_NOW + 1
ROWS = MATRIX + 36

# Behind the rows: room for what a formula wants to see as plain vectors, and then the work of effects, three rows for each
# formula that does any (its power, the sum over the stages, what it has done so far).
SCRATCH_POSE, SCRATCH_TWIST, SCRATCH_WRENCH, SCRATCH_MATRIX, SCRATCH_PAIR = 0, 7, 13, 19, 55
SCRATCH_U, SCRATCH_V, SCRATCH_TURN, SCRATCH_OWN, SCRATCH_OUT = 0, 6, 12, 14, 30
SCRATCH = 64  # a whole number of rows whatever the width

# Parameters of a controller, its gains behind them.
(
    LAW_PASSIVE, LAW_FAILED, LAW_STUCK, LAW_FAILS_AT, LAW_BRAKE_SPEED, LAW_COUPLED_MASS, LAW_RATE, LAW_DELAY, LAW_LAG, LAW_NOISE, LAW_STEP,
    LAW_CAMERA, LAW_NOISE_RAD, LAW_STEP_RAD, LAW_OBSERVER, LAW_LIMIT, LAW_MOTOR, LAW_FAILED_SENSOR, LAW_SEED, LAW_GAINS,
) = range(20)  # fmt: skip

# A controller's memory, in rows behind the work of effects: of the six legs direction and lever (six rows a leg), c of l'' = J a + c, and
# the force on each; then what it has sensed, commanded and done.
CONTROL_AXIS, CONTROL_BIAS, CONTROL_FORCE = 0, 6 * LEGS, 7 * LEGS
# Samples so far, time of the last step, largest force, energy taken out and its rate.
COUNTED, CLOCK, PEAK, TAKEN_OUT, POWER_BEFORE = range(8 * LEGS, 8 * LEGS + 5)
# Six rows each: command in force, force that follows it; last reading, elongation and speed that the law is given; what it commands.
HELD, LEVEL, READ, ESTIMATE, SPEED, COMMAND = range(POWER_BEFORE + 1, POWER_BEFORE + 1 + 6 * LEGS, LEGS)
TURN = COMMAND + LEGS  # theta_z and its rate from a camera
# True theta_z; whether the law is asked, whether an actuator has failed; time from which a command holds, that of the oldest one under
# way, and the next that something happens at, which a step of a sweep does not cross.
TRUE_TURN, DUE, FAILED, HOLDS, ARRIVAL, EVENT = range(TURN + 2, TURN + 8)
OWN_SIZE = 16
OWN, OWN_NEXT = EVENT + 1, EVENT + 1 + OWN_SIZE  # what the law keeps
QUEUED = OWN_NEXT + OWN_SIZE  # commands under way, each with the time from which it holds
TAKEN, QUEUE, QUEUE_LENGTH = QUEUED + 1, QUEUED + 2, 64
CONTROL_ROWS = QUEUE + 7 * QUEUE_LENGTH

# How far the later stages of a step of three look ahead, as a part of it (Heun's method of third order).
FIRST_OF_THREE, SECOND_OF_THREE = 1.0 / 3.0, 2.0 / 3.0

# How many runs stand side by side: one alone, a few, or as many as fill the registers.
ALONE, FEW, MANY = 1, 4, 16

# Columns of a sample: pose (7), twist (6), elongation, hysteretic force and whole force of the legs (6 each), energies (4); behind them
# the work of each formula that does any, and last the six forces of a controller, where there is one.
SAMPLE_POSE, SAMPLE_TWIST, SAMPLE_ELONGATION, SAMPLE_STORED, SAMPLE_FORCE, SAMPLE_ENERGY = 0, 7, 13, 19, 25, 31
POSE_SIZE = SAMPLE_TWIST - SAMPLE_POSE
BY_LEGS, BY_STOPS, BY_WEIGHT = 1, 2, 3
SAMPLE_SIZE = SAMPLE_ENERGY + 4
