"""Pages in a browser: curves can be read off, enlarged, put away and switched, in step, without an error."""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from measure.pages.figure import Figure, Line, Panel
from measure.pages.page import page_html
from measure.pages.summary import Summary

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
TEMPLATE = """{% extends "base.html.j2" %}{% from "parts.html.j2" import figure_part %}{% block body %}
<div class="switches"><label><input type="checkbox" checked data-switch="hub"> hub</label></div>
{{ figure_part(first) }}{{ figure_part(second) }}
<script id="try">window.addEventListener("load", () => {
  const [one, two] = [...document.querySelectorAll("figure")], plots = [one, two].map((f) => f.querySelector(".plot > svg")), said = {};
  const act = (type, x) => {
    const b = plots[0].getBoundingClientRect(), at = { clientX: b.left + x * b.width, clientY: b.top + 5 };
    plots[0].dispatchEvent(new PointerEvent(type, { ...at, pointerId: 1, pointerType: "touch" }));
  };
  act("pointermove", 0.5);
  said.values = [...one.querySelectorAll("output")].map((v) => v.textContent);
  said.cursors = plots.map((p) => p.querySelector(".cursor").getAttribute("d").split(" ")[0]);
  act("pointerdown", 0.2); act("pointerup", 0.6);
  said.zoomed = plots.map((p) => p.getAttribute("viewBox").split(" ").map((v) => Math.round(Number(v) / 100))[2]);
  said.ticks = [...one.querySelectorAll(".along span")].map((t) => t.textContent);
  one.querySelector(".whole").click();
  said.whole = plots.map((p) => Math.round(Number(p.getAttribute("viewBox").split(" ")[2])));
  one.querySelector(".legend button").click();
  said.away = [...one.querySelectorAll(".plot path.off")].map((p) => p.dataset.name);
  const hub = document.querySelector("input"); hub.checked = false; hub.dispatchEvent(new Event("change"));
  said.shown = [...two.querySelectorAll("path[data-when]:not(.off)")].map((p) => p.dataset.when);
  said.error = document.body.dataset.error || "";
  document.body.dataset.said = JSON.stringify(said);
});</script>{% endblock %}"""


def _figure(name: str) -> Figure:
    x = np.linspace(0.0, 10.0, 101)
    lines = [Line("line", x, 2 * x), Line("model", x, 3 * x, "effect", when="1"), Line("model", x, 4 * x, "effect", when="0")]
    return Figure(name, name, "time, s", [Panel("y, mm", lines)], link="run")


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_curves_are_read_off_enlarged_put_away_and_switched_together(tmp_path: Path):
    (tmp_path / "p.html.j2").write_text(TEMPLATE)
    page = tmp_path / "p.html"
    page.write_text(
        page_html(tmp_path / "p.html.j2", "A page", summary=Summary("ok", "good", "x"), first=_figure("a"), second=_figure("b"))
    )
    browser = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000", f"--user-data-dir={tmp_path}"]
    shown = subprocess.run([*browser, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=120, check=True).stdout
    found = re.search(r'data-said="([^"]*)"', shown)
    assert found
    said = json.loads(unescape(found[1]))
    assert said["error"] == ""
    assert [float(v) for v in said["values"]] == pytest.approx([10.0, 15.0], abs=0.3)
    assert said["cursors"] == ["M5000", "M5000"], "linked figures share their cursor"
    assert said["zoomed"] == [40, 40], "from 0.2 to 0.6 of the width, both"
    assert all(1.9 <= float(tick) <= 6.1 for tick in said["ticks"])
    assert said["whole"] == [10_000, 10_000]
    assert "line" in said["away"]
    assert said["shown"] == ["0"]
