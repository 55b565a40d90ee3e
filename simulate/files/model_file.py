"""The model file: TOML in, a checked model out, and back again."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import reduce
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import ValidationError

from measure.common.command_line import existing_file
from measure.common.errors import InputError, nearest
from measure.common.output import write_text
from simulate.effects import CATALOGUE
from simulate.model.effect import Catalogue, Effect, effect_from
from simulate.model.model import Model

SCHEMA = 1
_BESIDE_THE_MODEL = ("schema", "effect", "provenance")


def read_model(path: Path, catalogue: Catalogue = CATALOGUE) -> Model:
    """Read and check a model file.

    Raises
    ------
    InputError
        Not TOML, another schema, an unknown key (the nearest known one is named), a value that cannot be.
    """
    return model_from(read_document(path), str(path), catalogue)


def read_document(path: Path) -> dict[str, Any]:
    """The tables of a TOML file, unchecked.

    Raises
    ------
    InputError
        No such file, or not TOML.
    """
    existing_file(Path(path), what="a TOML file")
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not TOML: {error}. Mend the line or start from the shipped model.") from error


def model_from(document: Mapping[str, Any], where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """A checked model from the tables of a model file; `where` names the file in messages."""
    if document.get("schema") != SCHEMA:
        raise InputError(f"{where}: schema is {document.get('schema', 'absent')}; this program reads schema = {SCHEMA}.")
    base = {key: value for key, value in document.items() if key not in _BESIDE_THE_MODEL}
    _require_known_keys(base, Model, where, "")
    if "actuator" not in base:
        raise InputError(f"{where}: no [actuator] table; fit-actuator writes one from loops.")
    effects = _effects(document.get("effect", []), where, catalogue)
    try:
        return Model(**{**base, "effects": effects})
    except ValidationError as error:
        raise InputError(f"{where}: {_sentence(error)}") from error


def _effects(rows: Any, where: str, catalogue: Catalogue) -> tuple[Effect, ...]:
    if not isinstance(rows, list):
        raise InputError(f"{where}: effects are given as [[effect]], with double brackets.")
    made = []
    for row in rows:
        parameters = dict(row)
        name = parameters.pop("name", None)
        if name is None:
            raise InputError(f'{where}, [[effect]]: no name; give one such as name = "hub-inertia".')
        try:
            made.append(effect_from(catalogue, name, parameters))
        except (InputError, TypeError) as error:
            raise InputError(f"{where}: {error}") from error
    names = [effect.name for effect in made]
    if len(set(names)) < len(names):
        double = next(name for name in names if names.count(name) > 1)
        raise InputError(f'{where}: effect "{double}" stands there twice; keep one.')
    return tuple(made)


def _require_known_keys(table: Mapping[str, Any], kind: type, where: str, place: str) -> None:
    hints = get_type_hints(kind)
    known = [item.name for item in fields(kind) if item.name != "effects"]
    for key, value in table.items():
        if key not in known:
            known_here = [*known, *_BESIDE_THE_MODEL] if kind is Model else known
            raise InputError(f'{where}: unknown key "{place}{key}"; {nearest(key, known_here)}')
        inner = _table_kind(hints[key])
        if inner is not None and not isinstance(value, Mapping):
            raise InputError(f"{where}: {place}{key} is a value; it must be a table, [{place}{key}].")
        if inner is not None:
            _require_known_keys(value, inner, where, f"{place}{key}.")


def _table_kind(hint: Any) -> type | None:
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return next((option for option in options if isinstance(option, type) and is_dataclass(option)), None)


def _sentence(error: ValidationError) -> str:
    """The first complaint as a sentence: key, what is wrong, what was found."""
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"] if not _is_type_tag(part)) or "the model"
    found = repr(first["input"])
    found = found if len(found) < 80 else found[:77] + "..."
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "missing":
        return f"no {place}; it has no default, so give it."
    if first["type"] == "value_error":
        return f"{place}: {message}."
    return f"{place}: {message[0].lower()}{message[1:]}; found {found}."


def _is_type_tag(part: int | str) -> bool:
    return isinstance(part, str) and (part in ("float", "constrained-float") or part.startswith(("tuple[", "function-")))


def merged(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a model file with some values changed, as `[run.model]` gives them."""
    result = dict(document)
    for key, value in changes.items():
        old = result.get(key)
        result[key] = merged(old, value) if isinstance(value, Mapping) and isinstance(old, Mapping) else value
    return result


def document_of(model: Model, provenance: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The tables of the model's file."""
    tables: dict[str, Any] = {"schema": SCHEMA, "name": model.name}
    tables |= {
        item.name: _plain(getattr(model, item.name))
        for item in fields(Model)
        if item.name not in ("name", "effects") and getattr(model, item.name) is not None
    }
    if model.effects:
        tables["effect"] = [{"name": effect.name, **_plain(effect)} for effect in model.effects]
    if provenance is not None:
        tables["provenance"] = dict(provenance)
    return tables


def _plain(table: Any) -> Any:
    return {key: _listed(value) for key, value in asdict(table).items() if value is not None}


def _listed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _listed(inner) for key, inner in value.items() if inner is not None}
    if isinstance(value, tuple | list | np.ndarray):
        return [_listed(entry) for entry in value]
    return value


def write_model(model: Model, path: Path, provenance: Mapping[str, Any] | None = None) -> None:
    """Write a model as a file that every command accepts."""
    import tomli_w

    write_text(Path(path), tomli_w.dumps(document_of(model, provenance)))


def with_changes(model: Model, changes: Mapping[str, Any], where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """The model of one run: what `[run.model]` changes, checked like a model file."""
    known = {**catalogue, **{effect.name: type(effect) for effect in model.effects}}
    return model_from(merged(document_of(model), changes), where, known) if changes else model


def add_effects(model: Model, effects: tuple[Effect, ...]) -> Model:
    """The model with these effects added, each in place of one of the same name."""
    return reduce(Model.with_effect, effects, model)
