"""What Sphinx asks about docstrings and signatures: docstrings of this project are plain text, and types are named shortly."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.addnodes import desc_annotation
from sphinx.ext.napoleon import Config
from sphinx.ext.napoleon.docstring import NumpyDocstring

from generator.plain_text import restructured

_ARRAY = r"~?(numpy\.)?ndarray\[tuple\[~?(typing\.)?Any, \.\.\.\], ~?(numpy\.)?dtype\[~?(numpy\.)?floating\]\]"
_CONFIG: Any = Config(napoleon_use_rtype=False)


def as_restructured_text(app: Any, what: Any, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Rewrite the lines of a docstring in place; Sphinx calls it for each."""
    del app, thing, options
    lines[:] = NumpyDocstring(restructured(lines), _CONFIG, what="method" if what == "property" else what, name=name).lines()


def with_short_types(app: Any, what: str, name: str, thing: Any, options: Any, signature: str | None, returns: str | None) -> Any:
    """The signature of a function with `Array` in place of what it stands for; Sphinx calls it for each."""
    del app, what, name, thing, options
    return tuple(text and re.sub(_ARRAY, "Array", text).replace("<factory>", "...") for text in (signature, returns))


def with_short_properties(app: Any, doctree: Any, docname: str) -> None:
    """The same for the types of properties, which stand in the page already; Sphinx calls it for each page."""
    del app, docname
    for node in doctree.findall(desc_annotation):
        text = re.sub(_ARRAY, "Array", node.astext())
        if text != node.astext():
            node.children[:] = [nodes.Text(text)]
