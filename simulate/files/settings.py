"""Values of a model changed by their names, as `--set KEY=VALUE` gives them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from measure.common.errors import InputError
from measure.common.inputs import parsed_toml
from simulate.effects import CATALOGUE
from simulate.files.model_file import document_of, model_from, with_joint_radius, with_stored_force
from simulate.model.effect import Catalogue
from simulate.model.model import LEGS, Model, is_stored_force
from simulate.model.radii import RADII


def with_settings(model: Model, settings: Iterable[str], catalogue: Catalogue = CATALOGUE) -> Model:
    """The model with each `KEY=VALUE` worked in, checked like a model file.

    A key is named as in the file, `platform.mass_kg`, `actuator.b_l_N[0]`, or `effect.NAME.PARAMETER`, which adds the effect
    where it is absent. A value is written as in the file. `actuator.stored_force_N` is no key of the file: it moves b_l, b_u and
    the initial force together, of one leg with an index; `geometry.base_radius_m` and `geometry.platform_radius_m` move a ring of joints.

    Raises
    ------
    InputError
        No such key (the nearest is named), or a value that cannot be.
    """
    for setting in settings:
        key, _, text = setting.partition("=")
        where = f"--set {setting}"
        if is_stored_force(key.strip()):
            model = with_stored_force(model, key.strip(), _value(text, where), where, catalogue)
            continue
        if key.strip() in RADII:
            model = with_joint_radius(model, key.strip(), _value(text, where), where, catalogue)
            continue
        document = document_of(model)
        table, name = _table_of(document, key.strip().split("."), where)
        head, _, index = name.partition("[")
        value = _value(text, where)
        table[head] = _with_entry(table.get(head), index, value, where) if index else value
        model = model_from(document, where, catalogue)
    return model


def _value(text: str, where: str) -> Any:
    try:
        value = parsed_toml(f"value = {text}")["value"]
    except (ValueError, KeyError) as error:
        raise InputError(f"{where}: give KEY=VALUE with a value as in the model file, such as platform.mass_kg=0.9.") from error
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _table_of(document: dict[str, Any], parts: list[str], where: str) -> tuple[dict[str, Any], str]:
    """The table that holds the key, made where it is absent, and the key's last word."""
    if parts[0] == "effect":
        if len(parts) != 3:
            raise InputError(f"{where}: name the parameter of an effect as effect.NAME.PARAMETER.")
        return _effect_table(document, parts[1]), parts[2]
    table = document
    for part in parts[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise InputError(f"{where}: {part} is a value and holds no other.")
    return table, parts[-1]


def _effect_table(document: dict[str, Any], name: str) -> dict[str, Any]:
    rows = document.setdefault("effect", [])
    found = next((row for row in rows if row["name"] == name), None)
    if found is None:
        found = {"name": name}
        rows.append(found)
    return found


def _with_entry(current: Any, index: str, value: Any, where: str) -> list[Any]:
    entries = [current] * LEGS if isinstance(current, float) else list(current or ())
    place = index.rstrip("]")
    if not (place.isascii() and place.isdigit() and len(place) < 9) or int(place) >= len(entries):
        raise InputError(f"{where}: [{place}] is not one of its {len(entries)} entries; they count from 0.")
    entries[int(place)] = value
    return entries
