"""A commented TOML file from the JSON Schema of its format: every key with what it is, its unit, its limits and its default."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from measure.tables.frames import unit_in_name

_WIDTH = 118
_LONGEST_LINE = 90


def commented(schema: Mapping[str, Any], document: Mapping[str, Any], *, head: str = "", schema_file: str = "") -> str:
    """The text of a TOML file with a comment for every key.

    Parameters
    ----------
    schema : JSON Schema of the file, as pydantic makes it.
    document : the values that are given; every other key stands there as a comment.
    head : text for the top of the file, made a comment.
    schema_file : where the schema is, from the file; editors complete and check keys with it.
    """
    made = _Template(schema)
    lines = [f"#:schema {schema_file}"] if schema_file else []
    lines += [f"# {line}".rstrip() for line in head.splitlines()]
    return "\n".join([*lines, *([""] if lines else []), *made.table("", schema, document)]) + "\n"


class _Template:
    """The walk through a schema; definitions are looked up in `whole`."""

    def __init__(self, whole: Mapping[str, Any]) -> None:
        self.definitions = whole.get("$defs", {})

    def table(self, path: str, node: Mapping[str, Any], given: Mapping[str, Any]) -> list[str]:
        """The keys of a table, then the tables below it."""
        keys = {key: self.resolved(inner) for key, inner in node.get("properties", {}).items() if not inner.get("readOnly")}
        plain = [key for key, inner in keys.items() if not _is_table(inner) and not _is_row_of_tables(inner, self)]
        required = node.get("required", ())
        lines = [line for key in plain for line in self.entry(key, keys[key], given, key in required)]
        for key, inner in keys.items():
            below = f"{path}.{key}".lstrip(".")
            if _is_table(inner):
                lines += self.below(below, inner, given.get(key))
            elif _is_row_of_tables(inner, self):
                lines += self.rows(below, inner, given.get(key, ()))
        return lines

    def below(self, path: str, node: Mapping[str, Any], given: Mapping[str, Any] | None) -> list[str]:
        """A table with its head; where it is optional and not given, all of it is a comment."""
        optional = given is None and node.get("optional", False)
        inside = self.table(path, node, given or {})
        lines = ["", *_comment(node.get("description", "")), f"[{path}]", *inside]
        return [_as_comment(line) for line in lines] if optional else lines

    def rows(self, path: str, node: Mapping[str, Any], given: Sequence[Mapping[str, Any]]) -> list[str]:
        """Every given row of a list of tables; the first with its comments, an empty list as one commented example."""
        kind = self.resolved(node["items"])
        about = ["", *_comment(node.get("description", ""))]
        if not given:
            return [*about, *(_as_comment(line) for line in [f"[[{path}]]", *self.table(path, kind, {})])]
        lines = [*about, *_comment("keys of each:"), *(f"#   {self.said(key, inner)}" for key, inner in kind.get("properties", {}).items())]
        for row in given:
            lines += ["", f"[[{path}]]", *(f"{key} = {toml(value)}" for key, value in row.items() if not isinstance(value, Mapping))]
            for key, value in row.items():
                lines += [f"[{path}.{key}]", *_dotted(value)] if isinstance(value, Mapping) and value else []
        return lines

    def entry(self, key: str, node: Mapping[str, Any], given: Mapping[str, Any], required: bool) -> list[str]:
        """A key below its comment; as a comment itself where no value is given."""
        if key in given:
            return [*_comment(self.words(key, node, required)), f"{key} = {toml(given[key])}"]
        default = node.get("default")
        value = toml(default) if default not in (None, [], {}) else "..."
        return [*_comment(self.words(key, node, required)), f"#{key} = {value}"]

    def said(self, key: str, node: Mapping[str, Any]) -> str:
        """A key and its comment in one line."""
        return f"{key}: {self.words(key, self.resolved(node), 'default' not in node)}"

    def words(self, key: str, node: Mapping[str, Any], required: bool) -> str:
        """What a key is, its unit, its limits and its default."""
        description = " ".join(node.get("description", "").split())
        unit = unit_in_name(key)
        parts = [description, unit if unit and f", {unit}" not in description else "", *self.limits(node), _default(node, required)]
        return "; ".join(part for part in parts if part)

    def limits(self, node: Mapping[str, Any]) -> list[str]:
        """What a value may be, in words."""
        if "enum" in node:
            return [" or ".join(json.dumps(value) for value in node["enum"])]
        if node.get("several"):
            return ["one number, or a list of six, one a leg"]
        if node.get("type") == "array" and "prefixItems" in node and not isinstance(node["prefixItems"][0].get("items"), dict):
            return [f"{len(node['prefixItems'])} values"]
        low, high = node.get("minimum", node.get("exclusiveMinimum")), node.get("maximum", node.get("exclusiveMaximum"))
        if low is not None and low == high:
            return [f"always {low:g}"]
        if low is not None and high is not None:
            return [f"{low:g} to {high:g}"]
        words = {"exclusiveMinimum": "above", "minimum": "at least", "exclusiveMaximum": "below", "maximum": "at most"}
        return [f"{word} {node[name]:g}" for name, word in words.items() if name in node]

    def resolved(self, node: Mapping[str, Any]) -> dict[str, Any]:
        """A node with what it refers to laid below it; of several possible types the first, and whether there are more."""
        made = dict(node)
        choices = made.pop("anyOf", [])
        options = [option for option in choices if option.get("type") != "null"]
        if options:
            made = {**self.resolved(options[0]), **made}
            made |= {"several": len(options) > 1, "optional": len(options) < len(choices)}
        for inner in made.pop("allOf", ()):
            made = {**self.resolved(inner), **made}
        if "$ref" in made:
            made = {**self.definitions[made.pop("$ref").rpartition("/")[2]], **made}
        return made


def _is_table(node: Mapping[str, Any]) -> bool:
    return "properties" in node


def _is_row_of_tables(node: Mapping[str, Any], within: _Template) -> bool:
    return node.get("type") == "array" and isinstance(node.get("items"), dict) and _is_table(within.resolved(node["items"]))


def _default(node: Mapping[str, Any], required: bool) -> str:
    if required:
        return "must be given"
    default = node.get("default")
    if default in (None, [], {}):
        return "" if "absent:" in node.get("description", "") else "absent unless given"
    return f"default {toml(default)}"


def _comment(text: str) -> list[str]:
    paragraph = text.split("\n\n")[0]
    return [f"# {line}" for line in textwrap.wrap(" ".join(paragraph.split()), _WIDTH)]


def _as_comment(line: str) -> str:
    return line if line.startswith("#") or not line else f"#{line}"


def _dotted(table: Mapping[str, Any], before: str = "") -> list[str]:
    """The values of a table and those below it, by dotted keys."""
    lines = []
    for key, value in table.items():
        lines += _dotted(value, f"{before}{key}.") if isinstance(value, Mapping) else [f"{before}{key} = {toml(value)}"]
    return lines


def toml(value: Any) -> str:
    """A value as TOML has it; long lists take a line for each entry.

    Parameters
    ----------
    value : text, number, true or false, or a list or table of such.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list | tuple):
        inner = [toml(entry) for entry in value]
        line = f"[{', '.join(inner)}]"
        return line if len(line) <= _LONGEST_LINE else "[\n" + "".join(f"    {entry},\n" for entry in inner) + "]"
    return repr(value)
