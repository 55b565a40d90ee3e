"""`--fix`, `--bound` and `--start`: what a user wants of the parameters of a fit, for every command that fits."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from measure.common.inputs import number_in

if TYPE_CHECKING:
    from identify.estimation.parameters import Change, Parameter
    from identify.estimation.problem import Problem
    from simulate.model.effect import Effect


def add_parameter_options(made: ArgumentParser) -> None:
    """The three options, each repeatable."""
    group = made.add_argument_group("parameters", "names as in the results: beta_per_m, hub-inertia.mass_kg, test2.release.theta_z_rad")
    group.add_argument("--fix", action="append", default=[], metavar="NAME[=VALUE]", help="hold a parameter, at the model's value or this")
    group.add_argument(
        "--bound", action="append", default=[], metavar="NAME=LOW..HIGH", help="keep a parameter within; an end may be empty"
    )
    group.add_argument("--start", action="append", default=[], metavar="NAME=VALUE", help="where a parameter's fit begins")


def changes_from(
    given: Namespace, problem_of: Callable[[], Problem], effects: Iterable[type[Effect]] = (), *, valued: bool = True
) -> tuple[Change, ...]:
    """What the options say, checked against a problem's parameters and those of effects that may be tried.

    Parameters
    ----------
    problem_of : makes the problem; not asked where no option is given.
    valued : whether there is a model that a parameter can be held at without a value.

    Raises
    ------
    InputError
        An unknown name, a number that is none, or a value outside its bounds; all of them at once.
    """
    from measure.common.errors import InputError

    if not (given.fix or given.bound or given.start):
        return ()
    problem = problem_of()
    known: dict[str, Parameter] = {parameter.name: parameter for parameter in _tried(problem, effects)}
    known |= {parameter.name: parameter for parameter in problem.parameters}
    made, wrong = [], []
    for option, texts, read in (("--fix", given.fix, _held), ("--bound", given.bound, _bounded), ("--start", given.start, _started)):
        for text in texts:
            try:
                made.append(_checked(read(text, known), known, valued))
            except ValueError as error:
                wrong.append(f"{option} {text}: {error}")
    wrong += _twice(made)
    if wrong:
        raise InputError("\n".join(wrong))
    return tuple(made)


def _tried(problem: Problem, effects: Iterable[type[Effect]]) -> list[Parameter]:
    import numpy as np

    from identify.estimation.parameters import effect_parameters

    return [parameter for kind in effects for parameter in effect_parameters(kind(), problem.model, problem.measures, np.inf)]


def _named(text: str, known: Mapping[str, Parameter]) -> tuple[str, str]:
    """Name and what is behind the equals sign."""
    from measure.common.errors import nearest

    name, _, rest = text.partition("=")
    if name not in known:
        raise ValueError(f'no parameter "{name}"; {nearest(name, known)}')
    return name, rest


def _number(text: str, what: str) -> float:
    try:
        return number_in(text)
    except ValueError as error:
        raise ValueError(f"{what}: {error}; give a number.") from None


def _held(text: str, known: Mapping[str, Parameter]) -> Change:
    from identify.estimation.parameters import Change

    name, value = _named(text, known)
    return Change(name, _number(value, "the value") if value or "=" in text else None, held=True)


def _started(text: str, known: Mapping[str, Parameter]) -> Change:
    from identify.estimation.parameters import Change

    name, value = _named(text, known)
    return Change(name, _number(value, "the value"))


def _bounded(text: str, known: Mapping[str, Parameter]) -> Change:
    from identify.estimation.parameters import Change

    name, value = _named(text, known)
    ends = value.split("..")
    if len(ends) != 2:
        raise ValueError(f'"{value}" is no pair of bounds; write {name}=LOW..HIGH.')
    low, high = (_number(end, side) if end else None for end, side in zip(ends, ("the lower bound", "the upper bound"), strict=True))
    if low is not None and high is not None and not low < high:
        raise ValueError(f"the lower bound {low:g} is not below the upper one {high:g}.")
    return Change(name, low=low, high=high)


def _checked(change: Change, known: Mapping[str, Parameter], valued: bool) -> Change:
    """The change, where it can be."""
    parameter = known[change.name]
    if change.held and change.value is None and not valued:
        raise ValueError(f"no model gives its value; write --fix {change.name}=VALUE.")
    if change.value is not None and not parameter.log:
        low, high = parameter.value(parameter.low), parameter.value(parameter.high)
        if not low <= change.value <= high:
            raise ValueError(f"it is between {low:g} and {high:g}.")
    if parameter.log and change.value is not None and change.value <= 0.0:
        raise ValueError("it is above zero.")
    return change


def _twice(made: Iterable[Change]) -> list[str]:
    """A sentence on every parameter that is both held and begun elsewhere, or given a value twice."""
    valued = [change.name for change in made if change.held or change.value is not None]
    return [f"{name} is given a value twice; give it once." for name in dict.fromkeys(valued) if valued.count(name) > 1]
