"""Structured drawing of files and command lines, and how long is drawn: some examples in a usual run, minutes in a calibration."""

from __future__ import annotations

import contextlib
import copy
import signal
import time

import hypothesis
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from odd_inputs import CELLS, ODD

from measure.common.errors import InputError

SLOW = (HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example, HealthCheck.filter_too_much)
LONGEST_S = 20  # of processor time for one example
ROUND = 100  # examples drawn with one seed


class NoEnd(BaseException):
    """Nobody waits any longer; not an Exception, lest it is taken for one of the reader's own."""


def _too_late(number, frame):
    raise NoEnd


@contextlib.contextmanager
def patience():
    """Ends what has used up its processor time."""
    before = signal.signal(signal.SIGVTALRM, _too_late)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def read_or_refused(read, path):
    """Read a file; whether it was read. Whatever else it ends in than a sentence goes through."""
    try:
        with patience():
            read(path)
    except InputError as error:
        refusal = str(error)
    else:
        return True
    assert refusal.strip()
    return False


def drawn(strategy, check, examples, seed):
    """Try a claim on examples of a strategy; the least that breaks it is shown."""

    @hypothesis.seed(seed)
    @settings(max_examples=examples, derandomize=False, database=None, deadline=None, suppress_health_check=SLOW)
    @given(strategy)
    def claim(example):
        check(example)

    claim()


def drawn_for(strategy, check, seconds, seed):
    """The same with one seed after the other, for a time."""
    begun, rounds = time.monotonic(), 0
    while time.monotonic() - begun < seconds:
        drawn(strategy, check, ROUND, seed + rounds)
        rounds += 1


WORDS = (
    *("time_s", "elongation_m", "force_N", "z_m", "x_m", "theta_z_rad", "sigma_z_m", "status", "Time", "Weg (mm)", "Kraft [kN]", "Load"),
    *("", "p_bar", "time_s", "s", "mm", "N", '"', "\x1b[2J", "é", "力", "1", "nan", "=1+1", "a" * 300),
)  # fmt: skip
numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.floats(-1.0, 1.0).map("{:.6g}".format),
    st.integers(-(10**25), 10**25).map(str),
)
cells = st.one_of(numbers, numbers, st.sampled_from(CELLS), st.text(max_size=8))


@st.composite
def text_tables(draw):
    """A table as some software may write it: dialect, head, units, rows that are mostly numbers, encoding, and its faults."""
    columns = draw(st.integers(1, 5))
    mark, point = draw(st.sampled_from([(",", "."), (";", ","), ("\t", "."), (" ", "."), ("|", ","), (",", ",")]))
    ending = draw(st.sampled_from(["\n", "\r\n", "\r", "\n\n"]))
    head = draw(st.lists(st.lists(st.sampled_from(WORDS), min_size=columns, max_size=columns), max_size=3))
    notes = draw(st.lists(st.text(max_size=20), max_size=3))
    step, rows = draw(st.sampled_from([0.01, 1.0, -1.0, 0.0, 1e6, 1e-9])), draw(st.integers(0, 40))
    body = [[f"{(k * step):.9g}", *(f"{((k * 7 + c) % 11 / 10):.4f}" for c in range(1, columns))] for k in range(rows)]
    for _ in range(draw(st.integers(0, 3)) if body else 0):
        row = draw(st.integers(0, len(body) - 1))
        body[row][draw(st.integers(0, columns - 1))] = draw(cells)
    lines = [*notes, *(mark.join(row) for row in head), *(mark.join(cell.replace(".", point) for cell in row) for row in body)]
    text = ending.join(lines) + draw(st.sampled_from(["", ending, "\x00", ending + mark]))
    encoding = draw(st.sampled_from(["utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1", "gb18030", "shift-jis"]))
    return text.encode(encoding, "replace")


odd_values = st.one_of(
    st.sampled_from([value for value in ODD if not isinstance(value, float) or value == value]).map(copy.deepcopy),  # it may be filled
    st.floats(allow_nan=False),
    st.integers(-(2**62), 2**62),
    st.text(max_size=8),
    st.lists(st.one_of(st.floats(allow_nan=False), st.booleans(), st.text(max_size=4)), max_size=7),
    st.dictionaries(st.text(max_size=6), st.one_of(st.floats(allow_nan=False), st.text(max_size=4)), max_size=3),
)


@st.composite
def documents(draw, good, places):
    """A document of TOML with values changed, gone, or added under known and unknown names."""
    document = good()
    for _ in range(draw(st.integers(1, 4))):
        *way, last = draw(st.sampled_from(places))
        holder = document
        with contextlib.suppress(KeyError, IndexError, TypeError, AttributeError):
            for key in way:
                holder = holder[key]
            if draw(st.booleans()) and draw(st.booleans()):
                del holder[last]
            elif isinstance(holder, dict) and draw(st.integers(0, 4)) == 0:
                holder[draw(st.text(min_size=1, max_size=8))] = draw(odd_values)
            else:
                holder[str(last) if isinstance(holder, dict) else last] = draw(odd_values)
    return document


WIDTHS = (1, 2, 4, 8)
NUMBERS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)


@st.composite
def damaged(draw, sources):
    """A binary file of which fields hold other numbers, blocks are gone, doubled, moved or foreign, or the end is missing."""
    data = bytearray(draw(st.sampled_from(sources)))
    for _ in range(draw(st.integers(1, 5))):
        near = draw(st.booleans())
        place = draw(st.integers(0, max(0, min(len(data), 400 if near else len(data)) - 1)))
        how, length = draw(st.sampled_from(["field", "field", "field", "cut", "gone", "doubled", "foreign"])), draw(st.integers(1, 300))
        if how == "field":
            width = draw(st.sampled_from(WIDTHS))
            number = draw(st.one_of(st.sampled_from(NUMBERS), st.integers(0, 2**64 - 1))) % 256**width
            data[place : place + width] = number.to_bytes(width, draw(st.sampled_from(["little", "big"])))
        elif how == "cut":
            del data[place:]
        elif how == "gone":
            del data[place : place + length]
        elif how == "doubled":
            data[place:place] = data[place : place + length]
        else:
            data[place:place] = draw(st.binary(max_size=40))
    return bytes(data)
