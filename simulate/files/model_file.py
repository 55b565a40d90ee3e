"""The model file: TOML in, a checked model out, and back again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import reduce
from itertools import takewhile
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import ValidationError

from measure.common.errors import InputError, found, nearest
from measure.common.inputs import read_toml
from measure.common.output import write_text
from simulate.control.catalogue import known_laws
from simulate.effects import CATALOGUE
from simulate.model.control import Controller
from simulate.model.effect import Catalogue, Effect, effect_from
from simulate.model.model import LEGS, STORED_FORCE, Model, with_value
from simulate.model.possible import impossible, impossible_as_changed

SCHEMA = 1
_STORED = STORED_FORCE.partition(".")[2]
_BESIDE_THE_MODEL = ("schema", "effect", "controller", "provenance")


def read_model(path: Path, catalogue: Catalogue = CATALOGUE) -> Model:
    """Read and check a model file.

    Parameters
    ----------
    path : Path or str
        A TOML file, `schema = 1`.
    catalogue : effects that the file may name, by name.

    Returns
    -------
    Model
        In SI.

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
    return read_toml(path, what="a TOML file", advice="Mend the line or start from the shipped model.")


def model_from(document: Mapping[str, Any], where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """A checked model from the tables of a model file; `where` names the file in messages.

    Raises
    ------
    InputError
        Everything that is wrong, a line each.
    """
    base = {key: value for key, value in document.items() if key not in _BESIDE_THE_MODEL}
    known, unknown = _with_known_keys(base, Model, "")
    effects, of_effects = _effects(document.get("effect", []), catalogue)
    controller, of_controller = _controller(document.get("controller"))
    model, of_values = _checked_model({**known, "effects": effects, "controller": controller}, unknown)
    wrong = [*_wrong_schema(document), *unknown, *of_values, *of_effects, *of_controller]
    wrong = wrong or impossible(model)
    wrong = wrong or (impossible_as_changed(model.adjusted()) if model is not None else [])
    if model is None or wrong:
        raise InputError(f"{where}: " + "\n".join(wrong))
    return model


def _wrong_schema(document: Mapping[str, Any]) -> list[str]:
    schema = document.get("schema")
    if schema == SCHEMA and not isinstance(schema, bool):
        return []
    return [f"schema is {'absent' if schema is None else found(schema)}; this program reads schema = {SCHEMA}."]


_NO_ACTUATOR = """\
no [actuator] table; fit-actuator LOOPS --model THIS -o NEW puts one in, or add
[actuator]
a_l_N_per_m = 0.0        # h_l = a_l u + b_l, which the force approaches while the strip uncoils
b_l_N = 2.8
a_u_N_per_m = 0.0        # h_u = a_u u + b_u, while it is coiled
b_u_N = 2.9
beta_per_m = 400.0       # how fast
initial_force_N = 2.8    # at the release"""


def _checked_model(tables: Mapping[str, Any], unknown: list[str]) -> tuple[Model | None, list[str]]:
    """The model and what is wrong with values; a table that is not there is not asked for its keys."""
    if "actuator" not in tables:
        return None, [] if any("actuator" in text for text in unknown) else [_NO_ACTUATOR]
    try:
        return Model(**tables), []
    except ValidationError as error:
        return None, [text for key, text in _sentences(error).items() if not _only_misspelt(key, text, unknown)]


def _only_misspelt(key: str, text: str, unknown: list[str]) -> bool:
    """Whether a key is missing only because it stands there misspelt."""
    return text.startswith("no ") and any(f'did you mean "{key.rpartition(".")[2]}"' in said for said in unknown)


def _effects(rows: Any, catalogue: Catalogue) -> tuple[tuple[Effect, ...], list[str]]:
    """The effects that can be made, and what is wrong with the others."""
    if not isinstance(rows, list):
        return (), ["effects are given as [[effect]], with double brackets."]
    made: list[Effect] = []
    wrong: list[str] = []
    for row in rows:
        parameters = dict(row) if isinstance(row, Mapping) else {}
        name = parameters.pop("name", None)
        if not isinstance(name, str):
            wrong.append('[[effect]]: no name; give one such as name = "hub-inertia".')
            continue
        try:
            made.append(effect_from(catalogue, name, parameters))
        except (InputError, TypeError) as error:
            wrong.append(str(error))
    names = [effect.name for effect in made]
    wrong += [f'effect "{name}" stands there twice; keep one.' for name in dict.fromkeys(names) if names.count(name) > 1]
    return tuple(made), list(dict.fromkeys(wrong))


def _controller(table: Any) -> tuple[Controller | None, list[str]]:
    """The controller of a model file, and what is wrong with it."""
    if table is None:
        return None, []
    if not isinstance(table, Mapping):
        return None, ["controller is a value; it must be a table, [controller]."]
    law, laws = table.get("law"), known_laws()
    if not isinstance(law, str) or law not in laws:
        hint = nearest(law, laws) if isinstance(law, str) else f"take one of {', '.join(laws)}."
        return None, [f"controller.law is {'absent' if law is None else found(law)}; {hint}"]
    kind = laws[law]
    known, wrong = _with_known_keys({key: value for key, value in table.items() if key != "law"}, kind, "controller.")
    try:
        return kind(**known), wrong
    except ValidationError as error:
        texts = {f"controller.{key}": text for key, text in _sentences(error, "controller.").items()}
        return None, [*wrong, *(text for key, text in texts.items() if not _only_misspelt(key, text, wrong))]


def _with_known_keys(table: Mapping[str, Any], kind: type, place: str) -> tuple[dict[str, Any], list[str]]:
    """The table without keys that its class does not know, and a sentence for each of those."""
    hints = get_type_hints(kind)
    known = [item.name for item in fields(kind) if item.name != "effects"]
    known_here = [*known, *_BESIDE_THE_MODEL] if kind is Model else known
    kept: dict[str, Any] = {}
    wrong: list[str] = []
    for key, value in table.items():
        inner = _table_kind(hints[key]) if key in known else None
        if key not in known:
            wrong.append(f'unknown key "{place}{key}"; {nearest(key, known_here)}')
        elif inner is None:
            kept[key] = value
        elif isinstance(value, Mapping):
            kept[key], below = _with_known_keys(value, inner, f"{place}{key}.")
            wrong += below
        else:
            wrong.append(f"{place}{key} is a value; it must be a table, [{place}{key}].")
    return kept, wrong


def _table_kind(hint: Any) -> type | None:
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return next((option for option in options if isinstance(option, type) and is_dataclass(option)), None)


def _sentences(error: ValidationError, table: str = "") -> dict[str, str]:
    """A sentence for each key that is wrong: key, what is wrong, what was found. Of several types that it might have, the first."""
    by_key: dict[str, str] = {}
    for one in error.errors():
        place = ".".join(str(part) for part in takewhile(lambda part: not _is_type_tag(part), one["loc"])) or "the model"
        by_key.setdefault(place, _sentence(table + place if one["loc"] else table.rstrip(".") or place, dict(one)))
    return by_key


def _sentence(place: str, one: Mapping[str, Any]) -> str:
    message = one["msg"].removeprefix("Value error, ")
    if one["type"] == "missing":
        return f"no {place}; it has no default, so give it."
    if one["type"] == "value_error":
        return f"{place}: {message}."
    return f"{place}: {message[0].lower()}{message[1:]}; found {found(one['input'])}."


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
        if item.name not in ("name", "effects", "controller") and getattr(model, item.name) is not None
    }
    if model.controller is not None:
        tables["controller"] = model.controller.table()
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
    """Write a model as a file that every command accepts.

    Parameters
    ----------
    model : Model
        What is written.
    path : Path
        The TOML file; an older one is replaced as a whole.
    provenance : from what it was made; it becomes the table of that name.
    """
    import tomli_w

    write_text(Path(path), tomli_w.dumps(document_of(model, provenance)))


def with_changes(model: Model, changes: Mapping[str, Any], where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """The model of one run: what `[run.model]` changes, checked like a model file; the stored force, given by that name, last."""
    known = {**catalogue, **{effect.name: type(effect) for effect in model.effects}}
    of_law = changes.get("actuator")
    stored = of_law.get(_STORED) if isinstance(of_law, Mapping) else None
    if stored is None:
        return model_from(merged(document_of(model), changes), where, known) if changes else model
    others = {**changes, "actuator": {key: value for key, value in changes["actuator"].items() if key != _STORED}}
    return with_stored_force(with_changes(model, others, where, known), STORED_FORCE, stored, where, known)


def with_stored_force(model: Model, key: str, value: Any, where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """The model with b_l, b_u and initial force moved together, checked: `value` in N for the leg of the key, or for all, or six.

    Raises
    ------
    InputError
        No such leg, or a value that cannot be.
    """
    each: list[Any] = value if isinstance(value, list) and "[" not in key and len(value) == LEGS else [value]
    if not all(isinstance(force, int | float) and not isinstance(force, bool) and math.isfinite(force) for force in each):
        raise InputError(f"{where}: the stored force is a number in N, or without an index a list of six; found {found(value)}.")
    try:
        moved = with_value(model, key, tuple(float(force) for force in each) if len(each) > 1 else float(each[0]))
    except KeyError as error:
        raise InputError(f"{where}: [{key.partition('[')[2].rstrip(']')}] is not one of the six legs; they count from 0.") from error
    return model_from(document_of(moved), where, catalogue)


def with_joint_radius(model: Model, key: str, value: Any, where: str, catalogue: Catalogue = CATALOGUE) -> Model:
    """The model with a ring of joints at another mean radius, checked.

    Raises
    ------
    InputError
        No geometry, or a radius that cannot be.
    """
    if not isinstance(value, float) or not (math.isfinite(value) and value > 0.0):
        raise InputError(f"{where}: a radius is a number above zero, in m; found {found(value)}.")
    try:
        moved = with_value(model, key, value)
    except (KeyError, ValueError) as error:
        raise InputError(f"{where}: the model has no ring of joints; give [geometry].") from error
    return model_from(document_of(moved), where, catalogue)


def add_effects(model: Model, effects: tuple[Effect, ...]) -> Model:
    """The model with these effects added, each in place of one of the same name."""
    return reduce(Model.with_effect, effects, model)
