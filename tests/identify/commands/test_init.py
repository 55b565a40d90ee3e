"""The templates of `unspool init` are files that every command reads, hold every key, and agree with their schemas."""

from __future__ import annotations

import json
import tomllib

import pytest
from jsonschema import Draft202012Validator

from identify.campaign import campaign_file
from identify.commands.subcommands.shipped import shipped
from identify.commands.unspool import main
from measure.geometry import film_project
from measure.readers import column_mapping
from simulate.files import schema
from simulate.files.model_file import read_model

FORMATS = {"model": schema, "film": film_project, "bench": column_mapping, "campaign": campaign_file}


@pytest.fixture(scope="module", params=["prototype", "demo"])
def folder(request, tmp_path_factory):
    made = tmp_path_factory.mktemp(request.param) / "rig"
    assert main(["init", str(made), "--like", request.param, "--quiet"]) == 0
    return made


def keys_of(node, definitions):
    """Every key that a schema knows, at any depth, but those that commands write."""
    found = set()
    for key, inner in node.get("properties", {}).items():
        if not inner.get("readOnly"):
            found |= {key} | keys_of(inner, definitions)
    for choice in (*node.get("anyOf", ()), *node.get("allOf", ()), *([node["items"]] if node.get("items") else ())):
        found |= keys_of(choice, definitions) if isinstance(choice, dict) else set()
    if "$ref" in node:
        found |= keys_of(definitions[node["$ref"].rpartition("/")[2]], definitions)
    return found


@pytest.mark.parametrize("name", FORMATS)
def test_every_key_of_a_format_stands_in_its_template(folder, name):
    described = FORMATS[name].json_schema()
    text = (folder / f"{name}.toml").read_text()
    missing = [key for key in keys_of(described, described.get("$defs", {})) if key not in text]
    assert not missing


def undescribed(node, definitions, place=""):
    """Keys of a schema, at any depth, that do not say what they are."""
    found = []
    for key, inner in node.get("properties", {}).items():
        below = definitions[inner["$ref"].rpartition("/")[2]] if "$ref" in inner else inner
        found += [] if inner.get("description") or below.get("description") else [f"{place}{key}"]
        found += undescribed(below, definitions, f"{place}{key}.")
    return found


@pytest.mark.parametrize("name", FORMATS)
def test_every_key_says_what_it_is(name):
    described = FORMATS[name].json_schema()
    assert undescribed(described, described.get("$defs", {})) == []


@pytest.mark.parametrize("name", FORMATS)
def test_a_template_keeps_to_the_schema_beside_it(folder, name):
    written = json.loads((folder / "schemas" / f"{name}.schema.json").read_text())
    assert (folder / f"{name}.toml").read_text().startswith(f"#:schema schemas/{name}.schema.json\n")
    Draft202012Validator.check_schema(written)
    errors = list(Draft202012Validator(written).iter_errors(tomllib.loads((folder / f"{name}.toml").read_text())))
    assert not errors, errors[0].message


def test_a_schema_refuses_what_the_program_refuses():
    validator = Draft202012Validator(schema.json_schema())
    document = tomllib.loads(shipped("prototype.toml").read_text())
    assert validator.is_valid(document)
    for key, value in (("mas_kg", 1.0), ("mass_kg", -1.0)):
        assert not validator.is_valid({**document, "platform": {key: value}})
    assert not validator.is_valid({**document, "effect": [{"name": "hub-inertia", "mass": 0.1}]})
    assert not validator.is_valid({**document, "effect": [{"name": "hub-inertai"}]})


def test_the_model_is_the_one_it_is_like(folder):
    like = shipped("prototype.toml") if folder.parent.name.startswith("prototype") else shipped("demo") / "rig.toml"
    assert read_model(folder / "model.toml") == read_model(like)


def test_a_key_taken_out_of_its_comment_is_read(folder, tmp_path):
    text = (folder / "model.toml").read_text()
    assert "\n#step_s = ...\n" in text
    (tmp_path / "model.toml").write_text(text.replace("#step_s = ...", "step_s = 1e-4"))
    assert read_model(tmp_path / "model.toml").simulation.step_s == 1e-4


def test_nothing_is_written_over(folder, capsys):
    before = (folder / "model.toml").read_text()
    assert main(["init", str(folder)]) == 2
    assert "model.toml" in capsys.readouterr().err
    assert (folder / "model.toml").read_text() == before
