"""The JSON Schema of the model file, from the classes that check it and the catalogue of effects; editors complete keys with it."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from pydantic import TypeAdapter

from measure.tables.frames import unit_in_name
from simulate.control.catalogue import known_laws
from simulate.effects import CATALOGUE
from simulate.model.control import Controller
from simulate.model.effect import Catalogue, Effect
from simulate.model.rig import Rig


def json_schema(catalogue: Catalogue = CATALOGUE) -> dict[str, Any]:
    """The schema of a model file.

    Parameters
    ----------
    catalogue : kinds of effects that may stand in the file.
    """
    schema = TypeAdapter(Rig).json_schema()
    head = {"schema": {"const": 1, "default": 1, "description": "version of this format", "type": "integer"}}
    effects = {
        "type": "array",
        "description": "Physical effects of the catalogue, any number of such tables; unspool effects lists them.",
        "items": {
            "type": "object",
            "properties": {"name": {"type": "string", "description": "of the effect; its parameters stand beside it"}},
            "required": ["name"],
            "oneOf": [_of(kind) for kind in catalogue.values()],
        },
    }
    controller = {
        "type": "object",
        "description": "What acts on the legs beside their force law; absent: nothing does.",
        "required": ["law"],
        "oneOf": [_of_law(kind) for kind in known_laws().values()],
    }
    made_by = {"type": "object", "description": "what made the file; written by the commands", "readOnly": True}
    ordered = {"name": schema["properties"].pop("name"), **schema["properties"]}
    schema["properties"] = {**head, **ordered, "controller": controller, "effect": effects, "provenance": made_by}
    return {**schema, "title": "Model of a tape-spring hexapod", "required": ["schema", "actuator"]}


def _of_law(kind: type[Controller]) -> dict[str, Any]:
    schema = TypeAdapter(kind).json_schema()
    law = {"const": kind.law, "description": (kind.__doc__ or "").strip().splitlines()[0]}
    required = ["law", *schema.get("required", [])]
    return {"properties": {"law": law, **schema["properties"]}, "required": required, "additionalProperties": False}


def _of(kind: type[Effect]) -> dict[str, Any]:
    name = {"const": kind.name, "description": (kind.__doc__ or "").strip().splitlines()[0]}
    return {"properties": {"name": name, **{item.name: _parameter(item) for item in fields(kind)}}, "additionalProperties": False}


def _parameter(item: Any) -> dict[str, Any]:
    meta = item.metadata
    one = {"type": "number", "minimum": meta["low"], "maximum": meta["high"]}
    about = {"description": f"{meta['doc']}; {unit_in_name(item.name) or '1'}", "default": item.default}
    if not isinstance(item.default, tuple):
        return {**one, **about}
    size = len(item.default)
    return {"type": "array", "items": one, "minItems": size, "maxItems": size, **about, "default": list(item.default)}
