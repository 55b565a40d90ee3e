"""Figures of the page of a fit: loops with law and asymptotes, asymptotes over the rate, loops before and after a covariate."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit, corrected_force, line_at, polynomial_errors_of
from identify.actuator.rates_and_strokes import rates_of
from identify.report.loop_plots import asymptotes_are, binned, last_cycle, names_of, some_loops
from identify.report.phrases import with_error
from identify.report.rate_plots import line_alone
from measure.common.arrays import Array
from measure.pages.figure import Band, Figure, Line, Panel
from measure.pages.sections import Section, Table

LOOKS = ("one", "two", "three", "four", "five", "six")


def last_cycle_of(fit: ActuatorFit, k: int) -> tuple[Array, Array, Array]:
    """Elongation in mm, corrected force and residual in N of a loop's last full cycle, (n,) each."""
    kept = last_cycle(fit.loops[k])
    left = np.full(len(fit.loops[k].force_N), np.nan)
    left[fit.loops[k].used] = fit.residuals[k]
    return 1e3 * fit.loops[k].elongation_m[kept], corrected_force(fit, k)[kept], left[kept]


def loops_and_law(fit: ActuatorFit) -> Figure:
    """Two large panels: at most six loops with law and asymptotes, and what is left of them."""
    chosen = some_loops(fit.loops)
    cycles = [last_cycle_of(fit, k) for k in chosen]
    names = names_of(fit.loops, chosen)
    ends = np.array([min(u.min() for u, *_ in cycles), max(u.max() for u, *_ in cycles)])
    a_l, b_l, a_u, b_u, _ = fit.lines
    lines = [Line(name, u, force, look, dots=True) for name, look, (u, force, _) in zip(names, LOOKS, cycles, strict=False)]
    lines += [Line("law", u, force - left, "measured") for u, force, left in cycles]
    alone = asymptotes_are(fit)
    sides = ((f"upper asymptote{alone}", a_u, b_u), (f"lower asymptote{alone}", a_l, b_l))
    lines += [Line(name, ends, slope * ends / 1e3 + level, "limit") for name, slope, level in sides]
    what = f"{len(chosen)} of {len(fit.loops)} loops, last full cycles." if len(chosen) < len(fit.loops) else "Last full cycles."
    panels = [Panel("force, N", lines, height_px=340), _what_is_left(fit, names, cycles, ends)]
    return Figure("loops-and-law", "Measured loops, the law, and what is left", "elongation, mm", panels, what, large=True)


def _what_is_left(fit: ActuatorFit, names: Sequence[str], cycles: Sequence[tuple[Array, Array, Array]], ends: Array) -> Panel:
    noise = 2.0 * float(np.sqrt(np.mean([data.force_sigma_N**2 for data in fit.loops])))
    band = Band("noise of a sample, 2 sigma", ends, np.full(2, -noise), np.full(2, noise))
    left = [Line(name, u, rest, look, dots=True) for name, look, (u, _, rest) in zip(names, LOOKS, cycles, strict=False)]
    u, rest = (np.concatenate([cycle[i] for cycle in cycles]) for i in (0, 2))
    mean = Line("mean", *binned(u, rest), "measured")
    return Panel("measured minus modelled, N", [*left, mean], (band,), 260, 0.0)


def rate_section(fit: ActuatorFit) -> list[Section]:
    """Level and slope of the asymptotes over the rate with 95 % bands, each loop by itself, and the numbers; where they follow one."""
    rate = fit.fit.problem.rate
    if rate.abscissa == "none":
        return []
    x = rate.middle + rate.half * np.linspace(-1.0, 1.0, 41)
    seen = rates_of(fit.loops, rate.abscissa)
    alone = [line_alone(fit, k, data) for k, data in enumerate(fit.loops)]
    panels = [_over_rate(fit, x, seen, alone, which) for which in ("level", "slope")]
    axis = "frequency, Hz" if rate.abscissa == "frequency_Hz" else "mid-stroke speed, m/s"
    figure = Figure("asymptotes", f"Asymptotes over the rate, order {rate.order}", axis, panels, "Bands: 95 %. Dots: each loop by itself.")
    return [Section("How the asymptotes follow the rate", figures=[figure], tables=[_polynomials(fit)])]


def _over_rate(fit: ActuatorFit, x: Array, seen: Array, alone: Sequence[Array | None], which: str) -> Panel:
    lines, bands = [], []
    row = 1 if which == "level" else 0
    for side, look in (("lower", "one"), ("upper", "two")):
        place = row + 2 * (side == "upper")
        value, error = line_at(fit, place, x, fit.centre_m if row else None)
        single = np.array([np.nan if one is None else one[place] for one in alone])
        lines += [Line(f"{side} asymptote", x, value, look), Line(f"{side}, each loop", seen, single, "measured", dots=True)]
        bands.append(Band(f"{side}, 95 %", x, value - 1.96 * error, value + 1.96 * error))
    return Panel(f"level at {1e3 * fit.centre_m:.0f} mm, N" if row else "slope, N/m", lines, bands, 220)


def _polynomials(fit: ActuatorFit) -> Table:
    rate = fit.fit.problem.rate
    unit = "Hz" if rate.abscissa == "frequency_Hz" else "m/s"
    at = rate.middle + rate.half * np.array([-1.0, 0.0, 1.0])
    made, errors = fit.polynomials(), polynomial_errors_of(fit)
    rows = []
    for line, (name, of) in enumerate(zip(errors, ("N/m", "N", "N/m", "N"), strict=True)):
        values = [with_error(float(v), float(e)) for v, e in zip(*line_at(fit, line, at), strict=True)]
        rows.append([f"{name}, {of}", *values, *(with_error(c, e) for c, e in zip(made[name], errors[name], strict=True))])
    heads = ["line", *(f"at {one:.3g} {unit}" for one in at), *(f"coefficient of x^{j}" for j in range(rate.order + 1))]
    return Table("polynomials", "Values and coefficients with standard errors", heads, rows)


def covariate_section(fit: ActuatorFit) -> list[Section]:
    """Loops as measured and corrected to the mean of the covariate; where one was fitted."""
    name = fit.fit.problem.covariate
    if not name:
        return []
    chosen = some_loops(fit.loops)
    cycles, names = [last_cycle_of(fit, k) for k in chosen], names_of(fit.loops, chosen)
    kept = [last_cycle(fit.loops[k]) for k in chosen]
    before = [
        Line(text, u, fit.loops[k].force_N[places], look)
        for text, look, k, (u, *_), places in zip(names, LOOKS, chosen, cycles, kept, strict=False)
    ]
    after = [Line(text, u, force, look) for text, look, (u, force, _) in zip(names, LOOKS, cycles, strict=False)]
    panels = [Panel("as measured, N", before), Panel(f"corrected to the mean of {name}, N", after)]
    e = fit.estimates[f"covariate.{name}"]
    said = f"{with_error(e.value, e.stderr)} N per unit."
    return [Section(f"What {Path(name).name} does to the force", figures=[Figure("covariate", name, "elongation, mm", panels, said)])]
