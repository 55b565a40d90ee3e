"""Which further test would split a class best: each is predicted with the rivals' own fits, before anyone measures it.

One of two rivals makes the measurement, the other is fitted to it in the linearised model, with base, effects and the new run's
release free as far as everything measured before lets them. What is left, in units of the noise, is what the test would show:

    delta^2 = min |g + J x|^2 + |R x|^2 + |release - as drawn|^2

g the gap of the one's model to what the other made, J its Jacobian and R the root of the information so far. The test moves
the lead by delta^2 +- 2 delta towards the one that is true. A lead excludes where it is above ten and above what the
other's truth would let it be once in a hundred times; either of the two may be the true one, as their leads so far and
their parameters say.

Nobody knows the true one's parameters better than its fit does, nor how a platform will be let go that has not been let go yet;
with others the test may show less. So each makes the measurement with several sets, drawn from its covariance (as far as what
was measured bears them out) and from what `[nuisance]` says of releases, and the chance is the mean: a release just as it
should be lands on all its stops at once, which none does, and shows a multiple of what others do. The most telling tests are
predicted once more with more releases and by full simulation: a nonlinear effect can often follow where the linearised one cannot. Where a
single run is not sure enough to tell, several of the same kind are predicted together, as few as will do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from identify.criteria import LIKELY, RIVAL_P, ROUGHLY, STRONG_BIC
from identify.design.conditions import blank_film, blank_loop, deployments, loops
from identify.design.further_test import Condition, NextTest
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.problem import Fit, Problem
from measure.common.arrays import Array
from simulate.dispatch.threads import side_by_side

_DRAWS, _SEED = 12, 2009
_RELEASES, _AT_FIRST = 10, 2  # ways in which a further run may be let go; fewer until a test is among the most telling ones
_CHECKED, _MOST_CHECKED = 3, 6  # tests, the most telling ones, that are predicted by full simulation; more while none is likely
_STEPS = 8
_SURE, _MOST_RUNS = 0.9, 6  # a test is as many runs as split off a rival this often, but no more


def next_tests(best: Fit, rivals: Mapping[str, Fit]) -> tuple[NextTest, ...]:
    """Every test that can be predicted with these runs, the most telling first, from the fits of the foremost and of its rivals by name.

    Those that were predicted with more releases and by full simulation come before the others, whose chances are a first guess.
    """
    foremost = _Side.of(best)
    others = {name: _Side.of(rival) for name, rival in rivals.items()}
    conditions = (*deployments(best.problem), *loops(best.problem))
    found = sorted(side_by_side(lambda i: _predicted(foremost, others, conditions[i]), len(conditions)), key=_most_telling)
    checked: list[NextTest] = []
    while found and worth_a_closer_look(found[0], checked):
        checked.append(_predicted(foremost, others, found.pop(0).condition, closely=True))
    return (*sorted(checked, key=_most_telling), *found)


def worth_a_closer_look(guessed: NextTest, checked: Sequence[NextTest]) -> bool:
    """Whether a test is predicted by full simulation too, after those that were."""
    if not checked:
        return True
    enough = _CHECKED if any(test.surest >= LIKELY for test in checked) else _MOST_CHECKED
    return len(checked) < enough and _most_telling(guessed) < min(map(_most_telling, checked))


def _most_telling(test: NextTest) -> tuple[bool, float, str]:
    """Likely ones first, those that tell most for each of their runs before others."""
    return test.surest < LIKELY, -sum(test.chances.values()) / test.runs, test.condition.words


def _predicted(best: _Side, rivals: Mapping[str, _Side], condition: Condition, *, closely: bool = False) -> NextTest:
    """One run as a first guess; `closely`, with more releases and by full simulation, as many runs as it takes."""
    releases = likely_releases(best.fit.problem, condition, _RELEASES if closely else _AT_FIRST)
    by_best = _made(best, condition, releases)
    lines = _lines(best, by_best, releases)
    shows = {}
    for name, rival in rivals.items():
        by_rival = _made(rival, condition, releases)
        meetings = (_lines(rival, by_best, releases), by_best), (lines, by_rival)
        shows[name] = [_Shows.of(met, made, bent=closely) for met, made in meetings]

    def of(runs: int) -> NextTest:
        found = {name: _chance(best.fit, rival, [one.by(runs) for one in shows[name]]) for name, rival in rivals.items()}
        return NextTest(condition, found, runs)

    test = of(1)
    while closely and test.surest < _SURE and test.runs < _MOST_RUNS:
        test = of(test.runs + 1)
    return test


def _chance(best: Fit, rival: _Side, shown: Sequence[Array]) -> float:
    """How likely a test that shows so much tells the two apart, whichever is true."""
    before = float(np.sum(rival.fit.free_of_parameters(apart(best, rival.fit)[:, None]) ** 2))
    if_best, if_rival = shown
    return chance_of_split(rival.fit.cost - best.cost, before, (if_best, if_rival))


def apart(best: Fit, rival: Fit) -> Array:
    """By how much the gaps of another fit differ from a rival's, (m,) in its rows; the other lacks what an effect knows of itself."""
    shared, gaps = len(best.gaps) - _known_of_effects(best), -rival.gaps
    gaps[:shared] += best.gaps[:shared]
    return gaps


def _known_of_effects(fit: Fit) -> int:
    """How many parameters of its effects have a prior; these stand last."""
    return sum(bool(np.isfinite(one.spread)) for one in fit.problem.parameters[fit.problem.first_effect :])


def chance_of_split(lead: float, before: float, shown: tuple[Array, Array]) -> float:
    """How likely a further test excludes one of two effects, by the linearised theory of the lead.

    Parameters
    ----------
    lead : of the foremost over its rival so far, in the sum of squares.
    before : delta^2 of what was measured.
    shown : delta^2 of the test if the foremost is true, and if the rival is, (n,) each: one for each set of parameters it may have.
    """
    if_best, if_rival = (_excludes(side * lead, before, one) for side, one in zip((1.0, -1.0), shown, strict=True))
    odds = float(np.exp(-0.5 * np.clip(lead, -100.0, 100.0)))
    return (if_best + odds * if_rival) / (1.0 + odds)


def _excludes(lead: float, before: float, shown: Array) -> float:
    """How likely a test that shows so much brings the lead of the true effect to where it excludes the other; the mean over (n,).

    A rival that should be excluded by a lead as long as this and is not was kept for what linearised models do not show; then the lead has
    to grow as much as one that begins at nothing, so that a test that shows nothing is not believed to split anything.
    """
    spread = 2.0 * np.sqrt(shown) + 1e-12
    needed = _excluding_lead(before + shown)
    if lead > _excluding_lead(np.array(before)):
        needed = np.maximum(needed, lead + STRONG_BIC)
    return float(np.mean(special.ndtr((lead + shown - needed) / spread)))


def _excluding_lead(whole: Array) -> Array:
    """The lead that excludes a rival where all that was measured shows so much, (n,) each."""
    return np.maximum(STRONG_BIC, -2.0 * np.sqrt(whole) * float(special.ndtri(RIVAL_P)) - whole)


@dataclass(frozen=True)
class _Side:
    """One of the rivals: its fit, parameters as it has them and as they might be, and the root (k, k) of the information so far."""

    fit: Fit
    parameters: Sequence[Array]
    root: Array

    @classmethod
    def of(cls, fit: Fit) -> _Side:
        """With its own parameters first."""
        root = np.asarray(np.linalg.qr(fit.jacobian, mode="r"))
        return cls(fit, [fit.q, *likely_parameters(fit)], root)


def likely_parameters(fit: Fit) -> list[Array]:
    """Parameters (k,) from a fit's covariance, within their bounds, a dozen at most; always the same draws.

    Where an effect is not linear, the linearised model leads to parameters that the measurements do not bear out: one is kept as rarely
    as the sum of squares is there above the parabola.
    """
    power, turn = np.linalg.eigh(fit.covariance)
    spread = turn * np.sqrt(np.maximum(power, 0.0))
    bounds = np.array([(parameter.low, parameter.high) for parameter in fit.problem.parameters]).T
    chance = np.random.default_rng(_SEED)
    drawn = [np.clip(fit.q + spread @ chance.normal(size=len(fit.q)), *bounds) for _ in range(_DRAWS)]
    costs = [float(np.sum(gaps**2)) for gaps in fit.problem.gaps_beside([fit.q, *drawn])[1:]]
    above = [cost - float(np.sum((fit.gaps + fit.jacobian @ (q - fit.q)) ** 2)) for q, cost in zip(drawn, costs, strict=True)]
    return [q for q, more in zip(drawn, above, strict=True) if chance.random() < np.exp(-0.5 * max(more / fit.unit, 0.0))]


@dataclass(frozen=True)
class _Line:
    """A rival before a further run, linearised about where it would be if it knew the release, (r,).

    rows : (m, k), what its parameters do to that run, to what it knew, and to the release.
    further : (m,), which of them come anew with each run.
    """

    side: _Side
    release: Array
    rows: Array
    further: NDArray[np.bool_]

    @classmethod
    def of(cls, side: _Side, made: Problem, release: Array) -> _Line:
        """From the further run, whoever made it; only what was measured differs."""
        problem, fit = _meeting(side, made), side.fit
        jacobian = problem.jacobian(_placed(fit, problem, release))[1][: problem.measured]
        own = np.arange(problem.first_nuisance, problem.first_effect)
        shared = np.setdiff1d(np.arange(jacobian.shape[1]), own)
        kept = np.setdiff1d(np.arange(len(fit.q)), np.arange(fit.problem.first_nuisance, fit.problem.first_effect))
        n, old = len(jacobian), len(fit.q)
        rows = np.zeros((n + len(side.root) + len(own), old + len(own)))
        rows[:n, kept] = jacobian[:, shared]
        rows[:n, old:] = jacobian[:, own]
        rows[n : n + len(side.root), :old] = side.root
        rows[n + len(side.root) :, old:] = np.eye(len(own))
        at = np.arange(len(rows))
        return cls(side, release, rows, (at < n) | (at >= n + len(side.root)))

    def gaps(self, made: Sequence[Problem]) -> Array:
        """To the further run that another made with each of its sets of parameters, (m, n)."""
        problems = [_meeting(self.side, one) for one in made]
        q = _placed(self.side.fit, problems[0], self.release)
        gaps = np.zeros((len(self.rows), len(made)))
        gaps[: problems[0].measured] = np.stack([one.gaps(q)[: one.measured] for one in problems], axis=1)
        return gaps

    def shown(self, gaps: Array, runs: int = 1) -> Array:
        """delta^2 of so many runs alike, from the gaps (m, n) to one of them; (n,)."""
        return left_over(self.rows, gaps, self.further, runs)

    def bent(self, made: Problem) -> float:
        """delta^2 by fitting everything there is and the further run."""
        of = self.side.fit.problem.until(np.inf)
        problem = replace(of, films=(*of.films, *made.films), loops=(*of.loops, *made.loops))
        alone = _meeting(self.side, made)
        own = dict(
            zip((parameter.name for parameter in alone.parameters[alone.first_nuisance : alone.first_effect]), self.release, strict=True)
        )
        start = laid_out(self.side.fit, problem) + np.array([own.get(parameter.name, 0.0) for parameter in problem.parameters])
        found = solve(problem, start, most_steps=_STEPS, enough=ROUGHLY)
        return max(0.0, found.cost - self.side.fit.cost - float(self.release @ self.release))


def left_over(rows: Array, gaps: Array, further: NDArray[np.bool_], runs: int) -> Array:
    """Sum of squares (n,) that no step along rows (m, k) takes from gaps (m, n).

    further : (m,), the rows that come anew with each of the runs, whose own columns then do so too.
    """
    weight = np.where(further, np.sqrt(runs), 1.0)[:, None]
    step = np.linalg.lstsq(weight * rows, -weight * gaps, rcond=1e-12)[0]
    return np.sum((weight * (gaps + rows @ step)) ** 2, axis=0)


def _lines(side: _Side, made: Sequence[Sequence[Problem]], releases: Array) -> list[_Line]:
    return [_Line.of(side, problems[0], release) for problems, release in zip(made, releases, strict=True)]


@dataclass(frozen=True)
class _Shows:
    """What a further run shows one rival that another made it: for each release its line and gaps (m, n), and how much less by bending."""

    lines: Sequence[_Line]
    gaps: Sequence[Array]
    less: float

    @classmethod
    def of(cls, lines: Sequence[_Line], made: Sequence[Sequence[Problem]], *, bent: bool) -> _Shows:
        """bent : whether the rival is once fitted to everything there is; by how much less is left then holds for all."""
        gaps = [line.gaps(problems) for line, problems in zip(lines, made, strict=True)]
        straight = float(lines[0].shown(gaps[0])[0])
        return cls(lines, gaps, lines[0].bent(made[0][0]) / straight if bent and straight > 0.0 else 1.0)

    def by(self, runs: int) -> Array:
        """delta^2 of so many runs for all releases and sets of parameters, (n,)."""
        return self.less * np.concatenate([line.shown(gaps, runs) for line, gaps in zip(self.lines, self.gaps, strict=True)])


def _placed(fit: Fit, problem: Problem, release: Array) -> Array:
    """The parameters of a fit for a problem with a single run of which only the release is given."""
    q = laid_out(fit, problem)
    q[problem.first_nuisance : problem.first_effect] = release
    return q


def _blank(problem: Problem, condition: Condition) -> Problem:
    """A problem with nothing but a further run that has seen nothing yet."""
    if condition.frequency_Hz:
        return replace(problem.until(np.inf), films=(), loops=(blank_loop(problem, condition),))
    return replace(problem.until(np.inf), films=(blank_film(problem, condition),), loops=())


def likely_releases(problem: Problem, condition: Condition, many: int) -> Array:
    """How a further run may be let go, (many, r) in parameters; a single row of zeros for a loop."""
    blank = _blank(problem, condition)
    count = blank.first_effect - blank.first_nuisance
    if condition.frequency_Hz:
        return np.zeros((1, count))
    spreads = np.array([parameter.spread for parameter in blank.parameters[blank.first_nuisance : blank.first_effect]])
    return spreads * np.random.default_rng(_SEED).normal(size=(many, count))


def _meeting(side: _Side, made: Problem) -> Problem:
    """A rival's problem with nothing but a further run."""
    return replace(side.fit.problem.until(np.inf), films=made.films, loops=made.loops)


def _made(side: _Side, condition: Condition, releases: Array) -> list[list[Problem]]:
    """The further run as an effect would make it, without noise: for each release, with some of the effect's sets of parameters."""
    blank = _blank(side.fit.problem, condition)
    make = _loop_made if condition.frequency_Hz else _film_made
    made = []
    for i, release in enumerate(releases):
        some = side.parameters[i :: len(releases)] or side.parameters[:1]
        made.append(make(blank, [_placed(replace(side.fit, q=q), blank, release) for q in some]))
    return made


def _loop_made(blank: Problem, points: Sequence[Array]) -> list[Problem]:
    (loop,), exact = blank.loops, blank.with_exact_motion()
    made = []
    for q in points:
        force = loop.data.force_N.copy()
        force[loop.data.used] -= exact.gaps(q)[: blank.measured] * loop.data.force_sigma_N
        made.append(replace(blank, loops=(replace(loop, data=replace(loop.data, force_N=force)),)))
    return made


def _film_made(blank: Problem, points: Sequence[Array]) -> list[Problem]:
    (film,) = blank.films
    made = []
    for gaps in blank.gaps_beside(points):
        values = np.stack([film.values[i] - gaps[block.rows] * film.sigma[i] for i, block in enumerate(blank.blocks)])
        made.append(replace(blank, films=(replace(film, values=values),)))
    return made
