"""A page from a template: one HTML file that shows itself without asking any other address."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from measure.common.version import installed_version

_HERE = Path(__file__).parent
_WRITTEN_OUT = 1e7
_SCRIPTS = ("figures.js", "scene.js", "switches.js")


def page_html(template: Path, title: str, *, scripts: tuple[str, ...] = (), **shown: Any) -> str:
    """The whole page.

    Parameters
    ----------
    template : beside which others may stand; it extends `base.html.j2` of this room.
    title : of the page.
    scripts : texts of further scripts, trusted.
    shown : what the template shows; all of it is escaped.
    """
    from jinja2 import Environment, FileSystemLoader

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, loader=FileSystemLoader([template.parent, _HERE]))
    environment.filters |= {"num": number, "opened": opened, "json": json_of}
    own = [(_HERE / name).read_text(encoding="utf-8") for name in _SCRIPTS]
    style = (_HERE / "page.css").read_text(encoding="utf-8")
    return environment.get_template(template.name).render(title=title, style=style, scripts=[*own, *scripts], **shown)


def number(value: float | None, digits: int = 4) -> str:
    """A number with so many significant digits, a dash where there is none."""
    if value is None or value != value:
        return "\u2013"
    return f"{value:.0f}" if 10**digits <= abs(value) < _WRITTEN_OUT else f"{value:.{digits}g}"


def opened(text: str) -> str:
    """A text with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def json_of(data: Any) -> str:
    """Data for a script of the page, in which nothing ends the script."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def versions_in(note: Mapping[str, Any]) -> str:
    """The versions of a note of provenance, in a line."""
    return ", ".join(f"{name} {version}" for name, version in note.get("versions", {}).items())


def date_of_data(note: Mapping[str, Any]) -> str:
    """When the newest file that went in was last changed, as a day; a note holds no date of its own."""
    files = [Path(one["file"]) for one in note.get("inputs", ())]
    times = [path.stat().st_mtime for path in files if path.exists()]
    return f"{datetime.fromtimestamp(max(times), UTC):%d %B %Y}" if times else "unknown"


def facts_of(note: Mapping[str, Any], **first: str) -> dict[str, str]:
    """What every page says of itself: what the caller knows first, then date of the data and versions."""
    versions = dict(note.get("versions", {}))
    program = versions.pop("unspool", None) or installed_version()
    return {**first, "date of the data": date_of_data(note), "unspool": program, "versions": versions_in({"versions": versions})}
