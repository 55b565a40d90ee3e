"""The report of an explanation: one HTML page, figures inside, no outside address."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from identify.gap.gap_test import p_words
from identify.report import gap_plots
from identify.report.result import result_of
from identify.selection.explain import Explanation

_PAGE = Path(__file__).with_name("page.html.j2")


def report_html(found: Explanation, title: str, notes: Mapping[str, str], missing_force_file: str | None = None) -> str:
    """The whole page.

    Parameters
    ----------
    notes : headings and plain texts that stand last, such as what made the report.
    """
    from jinja2 import Environment

    environment = Environment(autoescape=True)
    page = environment.from_string(_PAGE.read_text(encoding="utf-8"))
    result = _defaulted(result_of(found, missing_force_file))
    words = {"num": number, "p_words": p_words}
    return page.render(title=title, r=result, figures=_figures(found), notes=dict(notes), **words)


def _defaulted(result: dict[str, Any]) -> dict[str, Any]:
    result["gap"].setdefault("held_out", None)
    return result


def _figures(found: Explanation) -> dict[str, str | None]:
    return {
        "elevation": embedded(gap_plots.elevation_figure(found)),
        "gaps": embedded(gap_plots.gaps_figure(found)),
        "ranking": embedded(gap_plots.ranking_figure(found)) if found.ranking else None,
        "missing": embedded(gap_plots.missing_force_figure(found.missing)) if found.missing is not None else None,
        "located": embedded(gap_plots.missing_force_figure(found.located)) if found.located is not None else None,
        "loops": embedded(gap_plots.loop_force_figure(found)) if found.before.problem.loops else None,
    }


def embedded(figure: Any) -> str:
    """A figure as an address that holds the picture itself."""
    from measure.common.figure_plots import save_figure

    buffer = io.BytesIO()
    save_figure(figure, buffer, "png")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def number(value: float | None) -> str:
    """A number with four significant digits, a dash where there is none."""
    return "–" if value is None or value != value else f"{value:.4g}"
