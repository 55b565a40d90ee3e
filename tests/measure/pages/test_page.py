"""The base of all pages: nothing is asked from outside, nothing that is shown can command the browser, nothing is left unnamed."""

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from measure.pages.figure import Figure, Line, Panel
from measure.pages.page import page_html
from measure.pages.summary import Number, Summary

HOSTILE = '<script>alert(1)</script>" onload="x'
TEMPLATE = """{% extends "base.html.j2" %}{% from "parts.html.j2" import figure_part, table_part, bars_part %}
{% block body %}{{ figure_part(figure) }}{{ table_part(words, [words, "n"], [[words, 1.5]]) }}
{{ bars_part(words, [{"name": words, "text": words, "share": 0.5, "look": "given"}], ["a", "b"]) }}
<script type="application/json" id="data">{{ {"a": words}|json|safe }}</script>{% endblock %}"""


class _Seen(HTMLParser):
    """The elements and attributes of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))


@pytest.fixture
def page(tmp_path: Path) -> str:
    path = tmp_path / "page.html.j2"
    path.write_text(TEMPLATE)
    t = np.linspace(0, 1, 5)
    figure = Figure(HOSTILE, HOSTILE, HOSTILE, [Panel(HOSTILE, [Line(HOSTILE, t, t)])], HOSTILE)
    summary = Summary(HOSTILE, "doubt", HOSTILE, [HOSTILE], [Number(HOSTILE, HOSTILE, HOSTILE)], [HOSTILE], {HOSTILE: HOSTILE})
    note = {"command": HOSTILE, "inputs": [{"file": HOSTILE, "sha256": "0"}], "versions": {}}
    return page_html(path, HOSTILE, summary=summary, figure=figure, note=note, words=HOSTILE)


def test_words_of_files_and_models_are_shown_and_never_run(page):
    assert "<script>alert" not in page
    assert not [tag for tag, attributes in _Seen(page).elements if "onload" in attributes]


def test_a_page_asks_no_other_address(page):
    for tag, attributes in _Seen(page).elements:
        for name in ("src", "href", "action", "data"):
            address = attributes.get(name)
            assert address is None or (tag == "a" and address.startswith(("#", "data:text/csv"))), (tag, name, address)
    assert "default-src 'none'" in page
    assert "@import" not in page
    assert "url(" not in page


def test_what_is_drawn_is_said_in_words_too(page):
    drawings = [attributes for tag, attributes in _Seen(page).elements if tag == "svg"]
    assert all(one.get("aria-hidden") == "true" or one.get("aria-label") for one in drawings)
    assert any(one.get("role") == "img" for one in drawings)


def test_a_page_has_its_language_one_title_and_heads_of_columns(page):
    elements = _Seen(page).elements
    assert ("html", {"lang": "en"}) in elements
    assert sum(tag == "h1" for tag, _ in elements) == 1
    assert all("scope" in attributes for tag, attributes in elements if tag == "th")
