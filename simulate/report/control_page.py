"""The page of a designed controller: certificate, margins, other laws, before and after, and one deployment in three dimensions."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from measure.common.figure_plots import save_figure
from simulate.control.task import Design
from simulate.deployment.deploy import deploy_many
from simulate.deployment.result import Deployment
from simulate.report.control_plots import control_figure
from simulate.report.replay_page import playing_html

_TABLES = Path(__file__).with_name("control.html.j2")
_FAN = 24  # draws that are shown


def control_html(design: Design) -> str:
    """The whole page: no outside address. The deployment that plays is the draw that turns farthest without control, beside that one."""
    before, after = _shown(design)
    worst = max(range(len(before)), key=lambda i: abs(before[i].summary["theta_z_deg"] or 0.0))
    free = replace(before[worst].trajectory, name="the same rig without control")
    return playing_html(after[worst], free, orange="without control", above=_tables(design, before, after))


def _shown(design: Design) -> tuple[list[Deployment], list[Deployment]]:
    """Draws without and with the controller; of its noise each has its own."""
    task, controller = design.task, design.controller or design.nearest
    rigs = list(task.uncertainty.drawn(replace(task.model, controller=None), _FAN, task.seed + 7))
    held = [replace(rig, controller=controller.reseeded(k)) for k, rig in enumerate(rigs)]
    return deploy_many(rigs), deploy_many(held)


def _tables(design: Design, before: Sequence[Deployment], after: Sequence[Deployment]) -> str:
    from jinja2 import Environment

    figure, buffer = control_figure(before, after, [r.angle_deg for r in design.task.requirements]), io.BytesIO()
    save_figure(figure, buffer, "png")
    picture = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
    page = Environment(autoescape=True).from_string(_TABLES.read_text(encoding="utf-8"))
    return page.render(report=design.report, picture=picture, gains=_gains(design.report))


def _gains(report: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(key, value) for key, value in report["controller"].items() if value not in (0, 0.0)]
