"""The reference of what `measure`, `simulate` and `identify` export: one page each, from docstrings."""

from __future__ import annotations

import importlib
import inspect
import re
from types import ModuleType

PACKAGES = ("measure", "simulate", "identify")


def page(package: str) -> str:
    """The page of a package as MyST Markdown: what its front door says, a list, and every name with its docstring."""
    door = importlib.import_module(package)
    names = list(door.__all__)
    rows = [f"| {{py:obj}}`{name} <{package}.{name}>` | {first_line(getattr(door, name))} |" for name in names]
    parts = [f"# {package}", first_line(door), "", "| name | is |", "| --- | --- |", *rows, "", "```{eval-rst}"]
    return "\n".join([*parts, *(_directive(package, door, name) for name in names), "```", ""])


def first_line(thing: object) -> str:
    """The opening line of a docstring, safe inside a table; what a plain value is where it has none."""
    if not (inspect.isclass(thing) or callable(thing) or inspect.ismodule(thing)):
        return f"`{thing!r}`"
    opening = (inspect.getdoc(thing) or "").split("\n\n")[0].replace("\n", " ")
    return re.split(r"(?<=\.) (?=\w+ : )", opening)[0].replace("|", "\\|")


def _directive(package: str, door: ModuleType, name: str) -> str:
    thing = getattr(door, name)
    if inspect.isclass(thing):
        return f".. autoclass:: {package}.{name}\n   :members:\n"
    if callable(thing):
        return f".. autofunction:: {package}.{name}\n"
    if inspect.ismodule(thing):
        return f".. py:module:: {package}.{name}\n\n   {first_line(thing)}\n"
    return f".. py:data:: {package}.{name}\n   :value: {thing!r}\n"
