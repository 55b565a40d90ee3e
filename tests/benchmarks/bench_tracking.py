"""How exactly marks are found, beside the usual methods in the same run.

    python tests/benchmarks/bench_tracking.py [--json FILE] [--repeats N]

Every line of the tables is measured now, on this machine. pyidi takes part where it is installed.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np
from tracking_methods import methods
from tracking_scenes import MIDDLE, NOISE, SUBSET, Pattern, bare, bound_px, noisy, picture

from measure.correlation.tracking import track_marks
from measure.footage.footage import from_array

FINE, COARSE = ("speckle", 1.0), ("speckle", 1.6)
SHIFTS = np.arange(0.0, 1.001, 0.05)
DRAWS = 16
PATTERNS = (FINE, COARSE, ("quadrant", 1.0), ("dot", 1.0))


def known_shifts(repeats):
    """Shifts of 0 to 1 px by 0.05: bias, RMSE over the bound, share of errors within the stated 95 % bar.

    A bias of 0.003 px is no bigger than one picture's noise: each shift is seen `repeats` times with other textures, and
    each of those in `DRAWS` draws of noise. bias_se_px is what of the bias is still chance, one standard deviation.
    """
    rows = {}
    for kind, grain in PATTERNS:
        patterns = [Pattern(kind, grain, n) for n in range(repeats)]
        films = [_drawn(patterns, (s, 0.31), 100_000 * i, DRAWS) for i, s in enumerate(SHIFTS)]
        bound = np.sqrt(np.mean([bound_px(pattern) ** 2 for pattern in patterns]))
        for name, find in methods().items():
            find(films[0][0])
            start = time.perf_counter()
            found = [[find(pair) for pair in pairs] for pairs in films]
            spent = (time.perf_counter() - start) / sum(len(pairs) for pairs in films)
            error = np.array([[place - (s, 0.31) for place, _ in row] for s, row in zip(SHIFTS, found, strict=True)])
            sigma = None if found[0][0][1] is None else np.array([[s for _, s in row] for row in found])
            rows[f"{patterns[0].name:12s} {name}"] = _shift_row(error, sigma, bound, spent)
    return rows


def _shift_row(error, sigma, bound, spent):
    row = {
        "bias_px": np.abs(error.mean(axis=1)).max(),
        "bias_se_px": error.std() / np.sqrt(error.shape[1]),
        "rmse_px": np.sqrt(np.mean(error**2)),
        "rmse_over_bound": np.sqrt(np.mean(error**2)) / bound,
        "us": 1e6 * spent,
    }
    return row if sigma is None else {**row, "inside_95_percent": 100.0 * np.mean(np.abs(error) < 1.96 * sigma)}


def _drawn(patterns, shift, seed, draws, **current):
    """Pairs of pictures before and after a shift: every pattern in several draws of noise."""
    bares = [(bare(pattern), bare(pattern, shift=shift, **current)) for pattern in patterns]
    seeds = [[seed + 2 * (n * draws + d) for d in range(draws)] for n in range(len(patterns))]
    return [np.array([noisy(still, s), noisy(moved, s + 1)]) for (still, moved), row in zip(bares, seeds, strict=True) for s in row]


def stress(repeats):
    """Errors under light, turn, compression, a rod and blur: the RMSE, its share of that in plain light, bias, and the largest.

    Light that falls by 30 % leaves less contrast for the same noise: by that alone the RMSE grows by sqrt((1 + 1 / 0.7^2) / 2) = 1.23.
    """
    rows, plain = {}, {}
    for label, pattern, make in _cases():
        films = [film for n in range(repeats) for film in make(Pattern(*pattern, n), n)]
        for name, find in methods().items():
            error = np.array([find(pictures)[0] - shift for pictures, shift in films])
            lost = ~np.isfinite(error).all(axis=1)
            kept = error[~lost]
            rms = np.sqrt(np.mean(kept**2)) if len(kept) else np.nan
            plain.setdefault((pattern, name), rms if label == "plain light" else np.nan)
            rows[f"{label:22s} {name}"] = {
                "rmse_px": rms,
                "over_plain": rms / plain[pattern, name],
                "bias_px": np.abs(kept.mean(axis=0)).max() if len(kept) else np.nan,
                "max_px": np.abs(kept).max() if len(kept) else np.nan,
                "flagged": int(lost.sum()),
            }
    return rows


def _cases():
    def shift(n):
        return np.random.default_rng([n, 7]).uniform(0.0, 1.0, 2)

    def single(**current):
        return lambda pattern, n: [(pair, shift(n)) for pair in _drawn([pattern], shift(n), 1000 * n, 4, **current)]

    def turning(matrix_of):
        """Thirty pictures on the way, so that a tracker can follow."""

        def film(pattern, n):
            parts = np.linspace(0.0, 1.0, 31)
            way = [picture(pattern, shift=p * shift(n), matrix=matrix_of(p), noise_seed=100 * n + i) for i, p in enumerate(parts)]
            return [(np.array(way), shift(n))]

        return film

    def rotation(p):
        angle = np.radians(30.0 * p)
        return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def compression(p):
        return np.diag([np.cos(np.radians(30.0 * p)), 1.0])

    def rod(grey, x, y):
        return np.where(np.abs(x - 52.0 + 0.1 * (y - 48.0)) < 3.0, 40.0, grey)

    yield "plain light", FINE, single()
    yield "light -30 %", FINE, single(light=lambda g, x, y: 0.7 * g)
    yield "light +30 %", FINE, single(light=lambda g, x, y: np.minimum(1.3 * g, 250.0))
    yield "light gradient 30 %", FINE, single(light=lambda g, x, y: g * (1.0 + 0.3 * x / 41.0))
    yield "  on 1.6 px speckle", COARSE, single(light=lambda g, x, y: g * (1.0 + 0.3 * x / 41.0))
    yield "  on a quadrant", ("quadrant",), single(light=lambda g, x, y: g * (1.0 + 0.3 * x / 41.0))
    yield "turn of 30 deg", FINE, turning(rotation)
    yield "theta_z of 30 deg", FINE, turning(compression)
    yield "rod of 6 px", COARSE, single(cover=rod)
    yield "  on 1.0 px speckle", FINE, single(cover=rod)


def running(pattern, n, noise=NOISE):
    """A mark that sets off and reaches 16 px per frame with the shutter open for half of the time: a blur of 8 px.

    Returns the film and where the mark is, (frames, 2), px.
    """
    speed = np.array([0.0, 0.0, 2.0, 5.0, 9.0, 13.0, 16.0, 16.0])
    at = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) + np.random.default_rng(n).uniform()
    film = [
        picture(pattern, shift=(0.31, y), blur=(0.0, v / 2), size=200, noise_seed=50 * n + i, noise=noise)
        for i, (y, v) in enumerate(zip(at, speed, strict=True))
    ]
    return np.array(film), np.stack([np.full(len(at), 0.31), at], axis=1)


def blurred_motion(repeats):
    """Errors in the frames that are blurred by 8 px, by our tracker with and without the exposure known, and by pyidi."""
    films = [running(Pattern(*COARSE, n), n) for n in range(repeats)]
    rows = {}
    for name, exposure in (("ours, exposure known", 0.5), ("ours, exposure unknown", 0.0)):
        gaps = []
        for film, at in films:
            marks = track_marks(from_array(film), [(MIDDLE, MIDDLE)], 1.0, SUBSET, exposure_s=exposure)
            gaps.append(np.stack([marks.x_px[:, 0], marks.y_px[:, 0]], axis=1) - MIDDLE - at + at[0])
        rows[name] = _row(np.array(gaps)[:, 6:])
    find = methods().get("pyidi LK")
    if find is not None:
        rows["pyidi LK"] = _row(np.array([find(film[: i + 1])[0] - at[i] + at[0] for film, at in films for i in (6, 7)]))
    return rows


def _row(error):
    kept = error[np.isfinite(error).all(axis=-1)]
    return {
        "rmse_px": np.sqrt(np.mean(kept**2)) if len(kept) else np.nan,
        "max_px": np.abs(kept).max() if len(kept) else np.nan,
        "flagged": int((~np.isfinite(error).all(axis=-1)).sum()),
        "of": int(np.prod(error.shape[:-1])),
    }


def large_motion(repeats):
    """Steps of 9 to 20 px from frame to frame: marks off by more than 0.1 px without being flagged."""
    ours_gaps, other_gaps = [], []
    find = methods().get("pyidi LK")
    for n in range(repeats):
        chance = np.random.default_rng([n, 3])
        at = np.cumsum(np.concatenate([[0.0], chance.uniform(9.0, 20.0, 7) * np.array([1, 1, 1, -1, -1, 1, -1])]))
        film = np.array([picture(Pattern(*COARSE, n), shift=(0.4, y), size=250, noise_seed=50 * n + i) for i, y in enumerate(at)])
        marks = track_marks(from_array(film), [(MIDDLE, MIDDLE)], 1.0, SUBSET)
        moved = np.stack([marks.x_px[:, 0], marks.y_px[:, 0]], axis=1) - [marks.x_px[0, 0], marks.y_px[0, 0]]
        ours_gaps.append((moved - np.stack([0 * at, at], axis=1))[1:])
        if find is not None:
            other_gaps.append(np.array([find(film[: i + 1])[0] - [0.0, at[i]] for i in range(1, len(at))]))
    rows = {"ours": ours_gaps, **({"pyidi LK": other_gaps} if other_gaps else {})}
    return {
        name: {**_row(np.array(g)), "off_by_0.1_unflagged": int((np.abs(np.array(g)) > 0.1).any(axis=-1).sum())} for name, g in rows.items()
    }


def covered(repeats):
    """A block slides over the mark, 2 px a frame: the largest error before the mark is flagged, and how many never are."""
    gaps, never = [], 0
    for n in range(repeats):

        def block(step):
            return lambda grey, x, y: np.where(x > 70.0 - 2.0 * step, 25.0, grey)

        film = np.array([picture(Pattern(*COARSE, n), shift=(0.3, 0.2), cover=block(i), noise_seed=50 * n + i) for i in range(16)])
        marks = track_marks(from_array(film), [(MIDDLE, MIDDLE)], 1.0, SUBSET)
        never += int(marks.observed[-1, 0])
        gaps.append(np.stack([marks.x_px[:, 0] - marks.x_px[0, 0], marks.y_px[:, 0] - marks.y_px[0, 0]], axis=1))
    return {"ours": {**_row(np.array(gaps)), "never_flagged": never}}


def show(title, rows):
    """One table."""
    columns = list(dict.fromkeys(key for row in rows.values() for key in row))
    print(f"\n{title}\n{'':44s}" + "".join(f"{column:>18s}" for column in columns))
    for name, row in rows.items():
        print(f"{name:44s}" + "".join(f"{row[c]:18.4g}" if c in row else f"{'':18s}" for c in columns))


def main():
    """Measure everything and print it."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--json", type=Path)
    options.add_argument("--repeats", type=int, default=12, help="textures for each line")
    given = options.parse_args()
    cv2.setNumThreads(1)
    result = {
        "known shifts, 0 to 1 px": known_shifts(given.repeats),
        "stress": stress(given.repeats),
        "blur of 8 px at 16 px per frame": blurred_motion(given.repeats),
        "9 to 20 px per frame": large_motion(given.repeats),
        "a block slides over the mark": covered(given.repeats),
    }
    for title, rows in result.items():
        show(title, rows)
    if given.json:
        given.json.write_text(json.dumps(result, indent=2, default=float))


if __name__ == "__main__":
    main()
