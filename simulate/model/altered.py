"""The same with other values, without checking them anew: for numbers that a fit works out, some hundred thousand times.

What a user writes is checked where it is made; `dataclasses.replace` would check whole parts of a model again at every step of a fit.
"""

from __future__ import annotations

from typing import Any, TypeVar

T = TypeVar("T")


def altered(one: T, **values: Any) -> T:
    """A dataclass with some of its fields changed; the values must be of the kinds that the fields have.

    Parameters
    ----------
    one : an instance of a dataclass without slots. values : new values by field.
    """
    made = object.__new__(type(one))
    fields: dict[str, Any] = type(one).__dataclass_fields__  # type: ignore[attr-defined]
    made.__dict__.update({name: one.__dict__[name] for name in fields} | values)
    return made
