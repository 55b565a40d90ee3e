"""`unspool effects`: the catalogue of physical effects, and one of them in detail."""

from __future__ import annotations

import textwrap
from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, examples, parser, run, say

if TYPE_CHECKING:
    from simulate.report.effect_text import EffectText

NAME = "unspool effects"
DOES = "List the physical effects that a model can lack, or describe one: formula, parameters, and how it looks."
_WIDTH = 100


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    from simulate.files.options import add_effects_option

    made = parser(NAME, DOES, output="write the text to this file")
    made.add_argument("name", nargs="*", metavar="NAME", help="effects to describe; without one all are listed")
    add_effects_option(made)
    return examples(made, "unspool effects", "unspool effects hub-inertia leg-mass --json effects.json")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    from measure.common.file_kinds import TEXT
    from measure.common.output_gate import Outputs

    with Outputs({"--output": given.output, "--json": given.json}, {}, given.effects, {"--output": TEXT}).held():
        chosen = _chosen(given)
        lines = [line for text in chosen for line in described(text)] if given.name else listed(chosen)
        _write(given, chosen, lines)
    if not given.quiet:
        say(*lines)
    return DONE


def _chosen(given: Namespace) -> list[EffectText]:
    from simulate.files.own_effects import catalogue_with
    from simulate.report.effect_text import text_of

    texts = {name: text_of(kind) for name, kind in catalogue_with(given.effects).items()}
    _require_known(given.name, texts)
    return [texts[name] for name in given.name] or list(texts.values())


def _require_known(names: Sequence[str], texts: dict[str, EffectText]) -> None:
    from measure.common.errors import InputError, nearest

    wrong = [f'no effect is named "{name}"; {nearest(name, texts)}' for name in names if name not in texts]
    if wrong:
        raise InputError("\n".join(wrong))


def listed(texts: Sequence[EffectText]) -> list[str]:
    """A line for each effect, and how to go on."""
    widest = max(len(text.name) for text in texts)
    lines = [f"{text.name:<{widest}}  {text.acts_on:<12} {text.opening}" for text in texts]
    return [*lines, "", f"next     unspool effects {texts[0].name}   its formula, its parameters, and how it looks"]


def described(text: EffectText) -> list[str]:
    """An effect in detail."""
    lines = [f"{text.name}   acts on: {text.acts_on}", ""]
    lines += [line for part in text.says.split("\n\n") for line in [*_wrapped(part), ""]]
    lines += [*textwrap.indent(text.formula, "      ").splitlines(), ""] if text.formula else []
    lines += [*_wrapped(f"In a loop: {text.in_loop}"), *_wrapped(f"In a deployment: {text.in_deployment}"), ""]
    lines += [line for row in text.parameters for line in _row(row)]
    example = [f"{row['name']} = {_noticeable(row)}" for row in text.parameters]
    return [*lines, "", "  in a model file", "      [[effect]]", f'      name = "{text.name}"', *(f"      {line}" for line in example), ""]


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="  ")


def _row(row: dict[str, Any]) -> list[str]:
    count = f" ({row['values']} values)" if row["values"] > 1 else ""
    off = row["off"][0] if isinstance(row["off"], list) else row["off"]
    bounds = f"{row['low']:g} to {row['high']:g}, off at {off:g}, noticeable at {row['noticeable']:g}"
    said = row["is"] + (f" ({row['source']})" if row["source"] else "")
    return [
        f"  {row['name']}{count}   {row['unit']}   {bounds}",
        *textwrap.wrap(said, _WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6),
    ]


def _noticeable(row: dict[str, Any]) -> str:
    one = f"{row['noticeable']:g}"
    return one if row["values"] == 1 else f"[{', '.join([one] * row['values'])}]"


def _write(given: Namespace, chosen: Sequence[EffectText], lines: Sequence[str]) -> None:
    from dataclasses import asdict

    from measure.common.output import write_json, write_text

    if given.output is not None:
        write_text(given.output, "\n".join(lines) + "\n")
    if given.json is not None:
        write_json(given.json, {"effects": [asdict(text) for text in chosen]})
