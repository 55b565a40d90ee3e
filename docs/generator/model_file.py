"""The reference of the model file: every key with its unit and default, from the classes that check it."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from generator.units import unit_of
from simulate.control.catalogue import known_laws
from simulate.model.control import Controller, SampledController
from simulate.model.model import Model

_HEAD = """# Model file

A model is one TOML file. It begins with `schema = 1`. Unknown keys are refused, and the nearest known one is named. A key without a
default must be given where its table is. An effect is added by `[[effect]]` with a `name` and its parameters, see the
[catalogue](effects/index.md).

| key at the top | is | default |
| --- | --- | --- |
| `schema` | version of the format | none: `schema = 1` |
"""


def page() -> str:
    """The page as MyST Markdown: a section for each table of the file, a row for each key."""
    hints = hints_of(Model)
    top = [item for item in fields(Model) if table_of(hints[item.name]) is None and item.name != "effects"]
    head = _HEAD + "".join(f"| `{item.name}` | {said_of(hints[item.name])} | {default_of(item)} |\n" for item in top)
    tables = [(item.name, table_of(hints[item.name])) for item in fields(Model) if item.name != "controller"]
    return head + "\n" + "\n".join(section(name, kind) for name, kind in tables if kind is not None) + "\n" + _controllers()


_CONTROLLERS = """## `[controller]`

What acts on the legs beside their force law; absent: nothing does. `law` names one of the laws below (or one's own, loaded by
`--effects`), its gains stand beside it, and so do these keys.

"""


def _controllers() -> str:
    """The controller: what all laws share, what sampled ones share, and the gains of each."""
    shared = [("every law", _rows(Controller, list(fields(Controller))))]
    own = [item for item in fields(SampledController) if item.name not in {known.name for known in fields(Controller)}]
    shared += [("laws with sensors and actuators", _rows(SampledController, own))]
    parts = [f"### Keys of {title}\n\n{_TABLE_HEAD}\n" + "\n".join(rows) + "\n" for title, rows in shared]
    for name, kind in known_laws().items():
        gains = [item for item in fields(kind) if item.name in kind.gains()]
        sampled = "" if kind.passive else "\n\nIt has sensors and actuators."
        parts.append(f'### `law = "{name}"`\n\n{inspect.getdoc(kind)}{sampled}\n\n{_TABLE_HEAD}\n' + "\n".join(_rows(kind, gains)) + "\n")
    return _CONTROLLERS + "\n".join(parts)


_TABLE_HEAD = "| key | is | unit | value | default |\n| --- | --- | --- | --- | --- |"


def _rows(kind: type, items: list[Any]) -> list[str]:
    hints, about = hints_of(kind), _descriptions(kind)
    return [f"| `{i.name}` | {about[i.name]} | {unit_of(i.name)} | {said_of(hints[i.name])} | {default_of(i)} |" for i in items]


def section(name: str, kind: type) -> str:
    """A table of the file and the tables inside it."""
    hints = hints_of(kind)
    own = [item for item in fields(kind) if table_of(hints[item.name]) is None]
    inner = [(f"{name}.{item.name}", table_of(hints[item.name])) for item in fields(kind)]
    about = _descriptions(kind)
    rows = [f"| `{i.name}` | {about[i.name]} | {unit_of(i.name)} | {said_of(hints[i.name])} | {default_of(i)} |" for i in own]
    text = [
        f"## `[{name}]`",
        "",
        inspect.getdoc(kind) or "",
        "",
        "| key | is | unit | value | default |",
        "| --- | --- | --- | --- | --- |",
        *rows,
        "",
    ]
    return "\n".join([*text, *(section(path, table) for path, table in inner if table is not None)])


def _descriptions(kind: type) -> dict[str, str]:
    """What each key of a table is."""
    return {name: (info.description or "").replace("|", "\\|") for name, info in vars(kind)["__pydantic_fields__"].items()}


def hints_of(kind: type) -> dict[str, Any]:
    """What each key may be, with its limits."""
    return get_type_hints(kind, include_extras=True)


def table_of(hint: Any) -> type | None:
    """The class behind a key that is a table of its own, else None."""
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return next((option for option in options if isinstance(option, type) and is_dataclass(option)), None)


def said_of(hint: Any) -> str:
    """What a value may be, for people."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return said_of(inner[0]) + "".join(_limit(rule) for rule in getattr(inner[1], "metadata", ()))
    if origin in (Union, UnionType):
        return ", or ".join(said_of(option) for option in inner if option is not NoneType)
    if origin is Literal:
        return " or ".join(f'`"{option}"`' for option in inner)
    if origin is tuple:
        return _row_of(inner)
    return {float: "number", int: "whole number", str: "text", bool: "true or false"}.get(hint, "table")


def _row_of(inner: tuple[Any, ...]) -> str:
    one = said_of(inner[0])
    if inner[-1] is Ellipsis:
        return f"list of {one}"
    return (
        f"{len(inner)} {one.replace('number', 'numbers', 1)}"
        if one.startswith("number ") or one == "number"
        else f"{len(inner)} times {one}"
    )


def _limit(rule: Any) -> str:
    signs = (("gt", "above"), ("ge", "at least"), ("lt", "below"), ("le", "at most"))
    return "".join(f" {word} {getattr(rule, key):g}" for key, word in signs if getattr(rule, key, None) is not None)


def default_of(item: Any) -> str:
    """The default of a key as TOML has it; a dash where it must be given, "absent" where it may be left out."""
    default = item.default if item.default_factory is MISSING else item.default_factory()
    if default is MISSING:
        return "must be given"
    if default is None:
        return "absent"
    return f"`{_toml(default)}`"


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    return f'"{value}"' if isinstance(value, str) else f"{value!r}"
