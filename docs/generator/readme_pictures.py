"""The two pictures of the README: the rig of the demonstration, and what its gap is without and with the effect that is named.

unspool demo -o out/demo && python docs/generator/readme_pictures.py out/demo
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

matplotlib.use("svg")
import matplotlib.pyplot as plt

from identify import compare, read_campaign
from simulate import Model, read_model

FOLDER = Path(__file__).resolve().parents[1] / "_static"
DARK, BLUE, RED, GREY = "#333333", "#1f77b4", "#c0392b", "#999999"


def rig_picture(model: Model, path: Path) -> None:
    """The rig from the front, stowed and deployed, and from above."""
    assert model.geometry is not None
    base, joints = np.array(model.geometry.base_joints_m), np.array(model.geometry.platform_joints_m)
    figure, (front, above) = plt.subplots(1, 2, figsize=(8.0, 3.4), width_ratios=(1.3, 1.0))
    heights = (model.geometry.stowed_height_m, GREY, "stowed"), (model.geometry.deployed_height_m, BLUE, "deployed")
    for height, colour, name in heights:
        top = joints + np.array([0.0, 0.0, height])
        for a, b in zip(base, top, strict=True):
            front.plot((a[0], b[0]), (a[2], b[2]), color=colour, lw=1.4)
        front.plot(top[:, 0], top[:, 2], color=colour, lw=5, solid_capstyle="round", label=name)
    front.plot(base[:, 0], base[:, 2], "o", color=DARK)
    front.set(xlabel="x, m", ylabel="z, m", aspect="equal", title="from the front, as the camera sees it")
    front.legend(frameon=False, loc="upper left")
    for number, (a, b) in enumerate(zip(base, joints, strict=True), start=1):
        above.plot((a[0], b[0]), (a[1], b[1]), color=BLUE, lw=1.4)
        above.annotate(f"{number}", a[:2], textcoords="offset points", xytext=(5, 3), color=DARK)
    above.plot(base[:, 0], base[:, 1], "o", color=DARK)
    above.fill(joints[:, 0], joints[:, 1], color=BLUE)
    above.set(xlabel="x, m", ylabel="y, m", aspect="equal", title="from above: legs 1 to 6")
    _saved(figure, path)


def result_picture(results: Path, path: Path) -> None:
    """Measured minus modelled elevation of a run that took no part, without and with the effect."""
    runs = [run for run in read_campaign([results / "data" / "campaign.toml"]) if not run.is_loop]
    figure, axes = plt.subplots(figsize=(8.0, 2.8))
    for name, colour, said in (("data/model.toml", RED, "law of the loops alone"), ("extended.toml", BLUE, "with hub inertia")):
        found = compare(read_model(results / name), runs)
        (curve,) = (curve for curve in found.curves if curve.run == "deployment-3.csv" and curve.channel == "z_m")
        axes.plot(curve.time_s, 1e3 * (curve.measured - curve.modelled), color=colour, lw=1.4, label=said)
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set(xlabel="time, s", ylabel="measured - modelled, mm", title="elevation of a deployment that took no part in the fit")
    axes.legend(frameon=False)
    _saved(figure, path)


def _saved(figure: Figure, path: Path) -> None:
    """Write a picture that reads on light and dark pages, the same bytes from the same data."""
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None}, facecolor="white")


if __name__ == "__main__":
    matplotlib.rcParams.update({"svg.hashsalt": "unspool", "svg.fonttype": "path", "font.size": 9})
    folder = Path(sys.argv[1])
    rig_picture(read_model(folder / "data" / "rig.toml"), FOLDER / "rig.svg")
    result_picture(folder, FOLDER / "result.svg")
