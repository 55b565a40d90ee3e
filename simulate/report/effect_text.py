"""An effect in words, taken from the effect itself: what it is, its formula, how it looks, its parameters."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass, fields
from typing import Any

from measure.tables.frames import unit_in_name
from simulate.model.effect import Effect

_LOOP, _DEPLOYMENT = re.compile(r"In a loop:|A loop "), re.compile(r"In a deployment:|A deployment does not")
_FORMULA = re.compile(r" |[\w,']+(\([\w, ]*\))? = ")


@dataclass(frozen=True)
class EffectText:
    """The docstring of an effect, taken apart.

    says : what it is and where it is from. formula : lines as they stand. in_loop, in_deployment : how it looks there.
    """

    name: str
    acts_on: str
    says: str
    formula: str
    in_loop: str
    in_deployment: str
    parameters: tuple[dict[str, Any], ...]

    @property
    def opening(self) -> str:
        """The first sentence."""
        return re.split(r"(?<=\.)\s", self.says, maxsplit=1)[0]


def text_of(kind: type[Effect]) -> EffectText:
    """An effect in words.

    Parameters
    ----------
    kind : of the catalogue, or one of the user's own; what its docstring lacks is empty.
    """
    formulas, prose = [], []
    for paragraph in _paragraphs(kind.__doc__ or ""):
        (formulas if _FORMULA.match(paragraph) else prose).append(paragraph)
    words = [re.sub(r"\s+", " ", paragraph).strip() for paragraph in prose]
    looks = [text for text in words if _LOOP.match(text) or _DEPLOYMENT.match(text)]
    loop, deployment = _looks(" ".join(looks))
    says = "\n\n".join(text for text in words if text not in looks)
    formula = "\n".join(inspect.cleandoc(block) for block in formulas)
    return EffectText(kind.name, kind.acts_on, says, formula, loop, deployment, tuple(map(_parameter, fields(kind))))


def _paragraphs(doc: str) -> list[str]:
    """The paragraphs of a docstring; what stands deeper than the text begins with a blank."""
    first, _, rest = doc.partition("\n")
    text = inspect.cleandoc(f"\n    {first}\n{rest}")
    return [paragraph for paragraph in re.split(r"\n\s*\n", text) if paragraph.strip()]


def _looks(text: str) -> tuple[str, str]:
    """What is said of a loop, and of a deployment."""
    found = _DEPLOYMENT.search(text)
    parts = (text[: found.start()], text[found.start() :]) if found else (text, "")
    loop, deployment = (re.sub(r"^In a (?:loop|deployment): ", "", part.strip()) for part in parts)
    return loop, deployment


def _parameter(item: Any) -> dict[str, Any]:
    meta = item.metadata
    return {
        "name": item.name,
        "unit": unit_in_name(item.name) or "1",
        "values": len(item.default) if isinstance(item.default, tuple) else 1,
        "off": list(item.default) if isinstance(item.default, tuple) else item.default,
        "low": meta["low"],
        "high": meta["high"],
        "noticeable": meta["typical"],
        "is": meta["doc"],
        "source": meta["source"],
    }
