"""The reference of the catalogue of effects: one page each, from the class itself, with what it does to a loop and to a deployment."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

from generator.effect_plots import at_size, draw_effect
from generator.units import unit_of
from simulate.effects import CATALOGUE
from simulate.model.effect import Effect

_HEAD = """# Catalogue of effects

An effect is added to a model by `[[effect]]` in its file, by `--set effect.NAME.PARAMETER=VALUE`, or is fitted to loops by
`fit-actuator --effect NAME`. Its defaults switch it off. `explain-gap` tries all of them. Effects that act on a leg or on the load
cell show in a loop; in a deployment every effect may show, but for those of the load cell.

| name | acts on | what it is | loop |
| --- | --- | --- | --- |
"""


def write_catalogue(folder: Path) -> None:
    """Write a page and a figure for each effect, and the list of all.

    Parameters
    ----------
    folder : it is made where it is absent.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, kind in CATALOGUE.items():
        drawn = draw_effect(kind, folder / f"{name}.svg")
        (folder / f"{name}.md").write_text(page(kind, drawn), encoding="utf-8")
    rows = [f"| [{name}]({name}.md) | {kind.acts_on} | {_opening(kind)} | {_loop(kind)} |" for name, kind in CATALOGUE.items()]
    toctree = ["", "```{toctree}", ":hidden:", "", *CATALOGUE, "```", ""]
    (folder / "index.md").write_text(_HEAD + "\n".join([*rows, *toctree]), encoding="utf-8")


def page(kind: type[Effect], drawn: str) -> str:
    """The page of an effect as MyST Markdown; `drawn` says what its figure shows."""
    parts = [
        f"# {kind.name}",
        "",
        *description(kind),
        "",
        "| parameter | unit | off | bounds | noticeable size | is |",
        "| " + "--- | " * 6,
    ]
    parts += [_row(item) for item in fields(kind)]
    shown = at_size(kind)
    example = "\n".join(f"{item.name} = {_toml(getattr(shown, item.name))}" for item in fields(kind))
    parts += ["", "## In a model file", "", "```toml", "[[effect]]", f'name = "{kind.name}"', example, "```"]
    parts += ["", "## How it looks", "", f"![What {kind.name} does]({kind.name}.svg)", "", drawn, ""]
    parts += ["## Source", "", f"`simulate.effects.{kind.__name__}`, in `{_file_of(kind)}`.", *_sources(kind), ""]
    return "\n".join(parts)


def description(kind: type[Effect]) -> list[str]:
    """The docstring of an effect: paragraphs as they are, formulas in blocks of their own."""
    paragraphs = inspect.cleandoc(_indented(kind.__doc__ or "")).split("\n\n")
    made: list[str] = []
    for text in paragraphs:
        formula = text.startswith("    ") or re.match(r"[\w,']+(\([\w, ]*\))? = ", text)
        made += ["```text", inspect.cleandoc(text), "```", ""] if formula else [_plain(text), ""]
    return made


def _indented(doc: str) -> str:
    """The docstring with its first line as deep as a paragraph, so that what stands deeper is seen as a formula."""
    first, _, rest = doc.partition("\n")
    return f"\n    {first}\n{rest}"


def _plain(text: str) -> str:
    return re.sub(r"([*|<\[\]])", r"\\\1", text)


def _opening(kind: type[Effect]) -> str:
    return _plain(inspect.cleandoc(kind.__doc__ or "").split("\n\n")[0].replace("\n", " "))


def _loop(kind: type[Effect]) -> str:
    return "shows" if kind.acts_on_shaker() else ""


def _row(item: Any) -> str:
    meta, size = item.metadata, len(item.default) if isinstance(item.default, tuple) else 1
    name = f"`{item.name}`" + (f" ({size})" if size > 1 else "")
    bounds = f"{meta['low']:g} to {meta['high']:g}"
    return f"| {name} | {unit_of(item.name)} | {_off(item.default)} | {bounds} | {meta['typical']:g} | {_plain(meta['doc'])} |"


def _off(value: float | tuple[float, ...]) -> str:
    """The default of a parameter, short where all entries of a vector are the same."""
    alike = isinstance(value, tuple) and len(set(value)) == 1
    return f"{_toml(value[0])} each" if isinstance(value, tuple) and alike else _toml(value)


def _toml(value: float | tuple[float, ...]) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    return f"{value:.1f}" if value == int(value) else f"{value:.4g}"


def _sources(kind: type[Effect]) -> list[str]:
    return [f"- `{item.name}`: {item.metadata['source']}" for item in fields(kind) if item.metadata["source"]]


def _file_of(kind: type[Effect]) -> str:
    return kind.__module__.replace(".", "/") + ".py"
