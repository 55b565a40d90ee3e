"""Measured against modelled as figures of a page: the model as given, its force law refitted, and with the effect; what is left below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.estimation.problem import Fit
from identify.gap.comparison import Curve, curves_of
from identify.gap.platform_force import MissingForce
from identify.selection.explanation import Explanation
from measure.common.arrays import Array
from measure.pages.figure import Band, Figure, Line, Panel
from measure.pages.in_use import shown_as

GIVEN, REFITTED, EFFECT, DRAFT = "model as given", "force law refitted", "with the effect", "with the draft"
MEASURED, NOISE = "measured", "noise, 2 sigma"
_FORCE_PANELS = (
    ("missing force, N", ((0, "vertical, up", "one"), (1, "lateral, x", "two"))),
    ("missing moment, N m", ((2, "about y", "three"),)),
)
_CLEAR = 5.0  # times the noise, root mean square, from which on a gap is no matter of noise


@dataclass(frozen=True)
class Stage:
    """A curve of one channel of one run under one model. when : the state of the switches in which it is shown."""

    name: str
    look: str
    curve: Curve
    when: str = ""


@dataclass(frozen=True)
class CurveRow:
    """A channel of a run under every model, the first as given or, of a run held out, refitted."""

    run: str
    channel: str
    stages: tuple[Stage, ...]
    held_out: bool = False

    @property
    def without(self) -> Curve:
        """Of the model with its law refitted and no effect: the gap that an effect has to close."""
        return next((stage.curve for stage in self.stages if stage.name == REFITTED), self.stages[0].curve)

    @property
    def visible(self) -> float:
        """Largest gap without an effect in parts of the measured range: what one sees of it."""
        span = float(np.ptp(self.without.measured))
        return float(np.max(np.abs(self.without.gap))) / span if span > 0.0 and len(self.without.gap) else 0.0

    @property
    def over_noise(self) -> float:
        """Root mean square gap without an effect over the noise."""
        curve = self.without
        return float(np.sqrt(np.mean((curve.gap / curve.sigma) ** 2))) if len(curve.gap) else 0.0


def curve_rows(found: Explanation, variants: Mapping[str, Fit] | None = None) -> list[CurveRow]:
    """Every channel of every run, those held out last.

    variants : fits with what was found switched on and off, by the state of the switches.
    """
    fits = [(GIVEN, "given", found.as_given, ""), (REFITTED, "refitted", found.before, "")]
    fits += [(EFFECT, "effect", fit, state) for state, fit in (variants or {}).items()] or (
        [(EFFECT, "effect", found.after, "")] if found.findings else []
    )
    fits += [(DRAFT, "three", found.drafted.fit, "")] if found.drafted is not None else []
    rows, drafts = _together(fits), found.drafted.held_with if found.drafted is not None else ()
    for held in found.held:
        own = [(REFITTED, "refitted", held.before, "")] + ([(EFFECT, "effect", held.after, "")] if found.findings else [])
        own += [(DRAFT, "three", fit, "") for fit in drafts if _runs(fit) == _runs(held.before)]
        rows += [CurveRow(one.run, one.channel, one.stages, held_out=True) for one in _together(own)]
    return rows


def _runs(fit: Fit) -> set[str]:
    return {block.run for block in fit.problem.blocks}


def _together(fits: Sequence[tuple[str, str, Fit, str]]) -> list[CurveRow]:
    curves = [[Stage(name, look, curve, when) for curve in curves_of(fit)] for name, look, fit, when in fits]
    return [CurveRow(stages[0].curve.run, stages[0].curve.channel, stages) for stages in zip(*curves, strict=True)]


def largest(rows: Sequence[CurveRow]) -> CurveRow:
    """Where one sees the gap best: of what stands clear of the noise, the channel whose gap is the largest part of its range."""
    most = max(row.over_noise for row in rows)
    return max((one for one in rows if one.over_noise >= min(_CLEAR, most)), key=lambda one: one.visible)


def largest_over_noise(rows: Sequence[CurveRow]) -> CurveRow:
    """Where the gap is the largest over its noise."""
    return max(rows, key=lambda one: one.over_noise)


def figure_of(one: CurveRow, *, name: str, tall: bool = False) -> Figure:
    """One channel over time with what is left below, all models on one scale."""
    factor, unit, label = shown_as(one.channel)
    first = one.without
    lines = [Line(MEASURED, first.time_s, factor * first.measured, "measured", dots=True)]
    lines += [Line(stage.name, stage.curve.time_s, factor * stage.curve.modelled, stage.look, when=stage.when) for stage in one.stages]
    left = [Line(stage.name, stage.curve.time_s, factor * stage.curve.gap, stage.look, when=stage.when) for stage in one.stages]
    noise = Band(NOISE, first.time_s, -2 * factor * first.sigma, 2 * factor * first.sigma)
    panels = [
        Panel(f"{label}, {unit}", lines, height_px=260 if tall else 190),
        Panel(f"measured minus modelled, {unit}", left, (noise,), 150, 0.0),
    ]
    title = f"{opened_name(label)} of {one.run}" + (", held out" if one.held_out else "")
    return Figure(name, title, "time, s", panels, _caption(one, factor, unit), f"time-{one.run}")


def opened_name(label: str) -> str:
    """A label with a capital."""
    return label[:1].upper() + label[1:]


def _caption(one: CurveRow, factor: float, unit: str) -> str:
    sizes = {
        stage.name: factor * float(np.max(np.abs(stage.curve.gap))) for stage in one.stages if stage.when in ("", "1" * len(stage.when))
    }
    return "Largest difference: " + ", ".join(f"{name} {size:.3g} {unit}" for name, size in sizes.items()) + "."


def loop_figure(found: Explanation, name: str = "loop") -> Figure | None:
    """The loop in which the gap is largest: force against elongation, measured, with the law before and after."""
    loops = {loop.run.name for loop in found.before.problem.loops}
    rows = [one for one in curve_rows(found) if one.run in loops and not one.held_out]
    return any_figure(found, max(rows, key=lambda row: row.over_noise), name) if rows else None


def any_figure(found: Explanation, one: CurveRow, name: str) -> Figure:
    """A deployment over time; a loop, one cycle of it, over the elongation."""
    problem = found.before.problem
    loop = next((loop for loop in problem.loops if loop.run.name == one.run and not one.held_out), None)
    if loop is None:
        return figure_of(one, name=name)
    samples = next(block.samples for block in problem.blocks if block.run == one.run)
    kept = last_cycle(loop.data.cycles.reversals, samples)
    return loop_curves(one, 1e3 * loop.data.elongation_m[samples], kept, name)


def last_cycle(reversals: Sequence[int], samples: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which samples (n,) belong to the last whole cycle, by the reversals of the record; all where there is none."""
    turns = [turn for turn in reversals if samples[0] <= turn <= samples[-1]]
    if len(turns) < 3:
        return np.ones(len(samples), dtype=bool)
    return (samples >= turns[-3]) & (samples <= turns[-1])


def loop_curves(one: CurveRow, elongation_mm: Array, kept: NDArray[np.bool_], name: str) -> Figure:
    """Force against elongation with what is left below, of the samples that are kept."""
    u, first = elongation_mm[kept], one.without
    lines = [Line(MEASURED, u, first.measured[kept], "measured", dots=True)]
    lines += [Line(stage.name, u, stage.curve.modelled[kept], stage.look) for stage in one.stages]
    left = [Line(stage.name, u, stage.curve.gap[kept], stage.look) for stage in one.stages]
    noise = Band(NOISE, np.sort(u), -2 * first.sigma[kept], 2 * first.sigma[kept])
    panels = [Panel("force, N", lines, height_px=260), Panel("measured minus modelled, N", left, (noise,), 150, 0.0)]
    return Figure(name, f"One cycle of {one.run}", "elongation, mm", panels, _caption(one, 1.0, "N"))


def force_figure(missing: MissingForce, name: str, title: str) -> Figure:
    """An estimated force on the platform along what it goes with, with its band of two standard deviations."""
    panels = []
    for label, columns in _FORCE_PANELS:
        told_of = [(column, words, look) for column, words, look in columns if np.isfinite(missing.sigma_N[:, column]).any()]
        if told_of:
            panels.append(
                Panel(label, [_force_line(missing, *one) for one in told_of], [_force_band(missing, *one) for one in told_of], 170, 0.0)
            )
    return Figure(name, title, missing.label, panels, "Bands: two standard deviations.")


def _force_line(missing: MissingForce, column: int, words: str, look: str) -> Line:
    return Line(words, missing.places, missing.force_N[:, column], look)


def _force_band(missing: MissingForce, column: int, words: str, look: str) -> Band:
    del look
    known = np.isfinite(missing.sigma_N[:, column])
    places, force, sigma = missing.places[known], missing.force_N[known, column], missing.sigma_N[known, column]
    return Band(f"{words}, 2 sigma", places, force - 2 * sigma, force + 2 * sigma)
