"""What the server of commands has ready before it forks: kernels that are loaded, and results that take minutes by themselves.

An explanation and the design of a controller are worked out once, from good inputs; each try then reads and checks its own inputs, takes
the ready result in place of the long work, and writes it as ever. The kills and the comparison of bytes do the whole work.
"""

from __future__ import annotations

import contextlib
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

from odd_inputs import DESIGN, TRACK, lay_out

WARMING = (
    ["simulate-deployment", "rig.toml", "-o", "out.csv", "--figure", "out.png"],
    ["fit-actuator", "loop.csv", "-o", "out.toml"],
    ["compare-model", "model.toml", "campaign.toml", "-o", "out2.png"],
    ["sweep-deployments", "model.toml", "--factor", "platform.mass_kg=+-1%", "-o", "sweep"],
    [*TRACK, "-o", "track.csv"],
)
WITH_READY_RESULTS = (
    ["explain-gap", "model.toml", "test.csv", "-o", "gap"],
    ["design-control", "rig.toml", "--draws", "16", "-o", "law.toml", "--page", "law.html"],
    ["design-deployment", "rig.toml", *DESIGN, "-o", "law.toml"],
)


def prepare() -> None:
    """Run each command once here, and put ready results in the place of the long work.

    What a command compiles at its first run on a machine is no part of the time of a try.
    """
    lay_out(Path())
    for words in WARMING:
        _run(words)
    _explanation_ready()
    _design_ready()
    for words in WITH_READY_RESULTS:
        _run(words)


def _run(words: list[str]) -> None:
    from command_server import MAINS, import_module

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = import_module(MAINS[words[0]]).main(words[1:])
    assert status in (0, 1), said.getvalue()


def _explanation_ready() -> None:
    from identify.campaign.runs import read_campaign
    from identify.selection import explain as module
    from identify.selection.hypotheses import BUDGETS
    from simulate.files.model_file import read_model

    found = module.explain(read_model(Path("model.toml")), read_campaign([Path("test.csv")]), budget=BUDGETS["quick"])

    def ready(*given: Any, **named: Any) -> Any:
        return found

    module.explain = ready


def _design_ready() -> None:
    from simulate.control import design as module
    from simulate.control.catalogue import known_laws
    from simulate.control.gain_search import Found, Search
    from simulate.control.task import Design, Requirement, Task
    from simulate.control.uncertainty import Uncertainty
    from simulate.files.model_file import read_model

    model, law = read_model(Path("rig.toml")), "mechanical-link"
    task = Task(model, law, {}, 1.5, (Requirement(179.0, 0.5),), Uncertainty(0.1, 1e-3, 2e-3, 3e-4), 0.6, 16, 0)

    class Quick(Search):
        def least(self, most_N: float, seed: int) -> Found:
            return self.best(None, seed, points=2, fine=1)

    module._MARGIN_DRAWS = module._RIVAL_DRAWS = 4
    module.Search, module.known_laws = Quick, lambda: {law: known_laws()[law]}
    found = module.design_control(task)
    module.known_laws = known_laws

    def ready(task: Task, say: Any = None, foretell: Any = None) -> Design:
        module._require_possible(task)
        module._rise_s(task.model)
        return replace(found, task=task)

    module.design_control = ready
