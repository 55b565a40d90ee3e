"""The force law of a leg as an FMU (FMI 3.0, co-simulation), for the tools of others; they need Python to run it."""

from __future__ import annotations

import inspect
import json
import re
import tempfile
import uuid
import zipfile
from importlib import import_module
from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.common.output import replacing
from measure.common.version import versions_of
from simulate.law import restoring_force
from simulate.model.effect import Effect
from simulate.model.model import Model, per_leg
from simulate.model.rig import LEGS

_HEAD = '''"""The force law of a leg, written by unspool."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
from pythonfmu3 import Fmi3Causality, Fmi3Initial, Fmi3Slave, Fmi3StepResult, Fmi3Variability, Float64, Unit

'''
_PARAMETERS = {
    "a_l_N_per_m": ("N/m", "slope of the lower asymptote, approached while the strip uncoils"),
    "b_l_N": ("N", "lower asymptote at elongation 0"),
    "a_u_N_per_m": ("N/m", "slope of the upper asymptote, approached while the strip is coiled"),
    "b_u_N": ("N", "upper asymptote at elongation 0"),
    "beta_per_m": ("1/m", "how fast the force approaches an asymptote"),
    "initial_force_N": ("N", "force at the elongation that is set before the first step"),
}
_INPUTS = {
    "u_m": ("m", "elongation at the end of the step, positive when strip uncoils"),
    "speed_m_per_s": ("m/s", "its rate there; where it changes sign the leg turns round within the step. Zero throughout: it is not used"),
}
_OUTPUT = "force with which the leg pushes at the end of the step"
_TIME = (1980, 1, 1, 0, 0, 0)  # of every file in the archive, so that the same model gives the same bytes


def require_fmu(model: Model, leg: int | None) -> None:
    """Refuse what no FMU can be written of; before any work.

    Raises
    ------
    InputError
        pythonfmu3 is not installed, the legs differ and none is named, an effect changes the law itself.
    """
    try:
        import_module("pythonfmu3")
    except ImportError as error:
        raise InputError('pythonfmu3, which packs an FMU, is not installed. Install it with pip install "unspool[fmu]".') from error
    changing = [effect.name for effect in model.effects if effect.leg_asymptotes is not None or effect.strip_elongation is not None]
    changing += ["actuator.rate"] if model.actuator.rate is not None else []
    if changing:
        raise InputError(
            f"{model.name}: {', '.join(changing)} changes the asymptotes or the elongation itself, and the FMU holds the law with constant "
            "ones. Fit the loops without it, or take it out of the model."
        )
    differing = [name for name in _PARAMETERS if np.ptp(per_leg(getattr(model.actuator, name))) > 0.0]
    if leg is None and differing:
        raise InputError(f"{model.name}: the legs differ in {', '.join(differing)}. Name one with --leg 1 to --leg {LEGS}.")


def left_out(model: Model) -> list[Effect]:
    """The effects of a model that add to the force of a leg and are not in its FMU: friction, inertia."""
    return [effect for effect in model.effects if effect.leg_force is not None or effect.leg_mass is not None]


def write_fmu(model: Model, path: Path, leg: int | None = None) -> None:
    """Write the force law of a leg as an FMU: elongation in, force out, exact along every step; the same model gives the same bytes.

    Parameters
    ----------
    model : its force law and what acts on its legs.
    path : ends in .fmu.
    leg : 1 to 6; may be left out where all legs are alike.

    Raises
    ------
    InputError
        As `require_fmu`; another ending; the file cannot be written.
    """
    path = Path(path)
    if path.suffix != ".fmu":
        raise InputError(f"{path}: an FMU ends in .fmu. Name it so.")
    require_fmu(model, leg)
    with tempfile.TemporaryDirectory() as folder, replacing(path) as temporary:
        _repack(_built(Path(folder), law_of(model, leg)), temporary)


def law_of(model: Model, leg: int | None) -> dict[str, object]:
    """What the leg in the FMU reads when it begins: parameters with units and words, and what it is the law of."""
    values = {name: float(per_leg(getattr(model.actuator, name))[(leg or 1) - 1]) for name in _PARAMETERS}
    apart = [f"{effect.name} ({', '.join(f'{value:g}' for value in effect.flat())})" for effect in left_out(model)]
    what = f"force law of {'a leg' if leg is None else f'leg {leg}'} of {model.name}"
    return {
        "description": what + (f"; without {', '.join(apart)}" if apart else ""),
        "version": versions_of(("unspool",))["unspool"],
        "parameters": {name: (values[name], *words) for name, words in _PARAMETERS.items()},
        "inputs": _INPUTS,
        "output": _OUTPUT,
    }


def _built(folder: Path, law: dict[str, object]) -> Path:
    """The FMU as pythonfmu3 packs it: its own Python files and libraries, the source of the leg, and the law."""
    slave = import_module("simulate.files.leg_slave")
    constants = f"UNITS = {slave.UNITS!r}\nSTATE = {slave.STATE!r}\n"
    parts = [constants, *(inspect.getsource(part) for part in (restoring_force, slave.turning_point, slave.Leg))]
    (folder / "leg.py").write_text(_HEAD + "\n\n".join(parts), encoding="utf-8")
    (folder / "law.json").write_text(json.dumps(law, ensure_ascii=False), encoding="utf-8")
    can = ("canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize")
    made = folder / "made"
    return import_module("pythonfmu3").FmuBuilder.build_FMU(folder / "leg.py", made, [folder / "law.json"], **dict.fromkeys(can, True))


def _repack(built: Path, target: Path) -> None:
    """The same archive in the order of its names, without the time of its making, its token made of its content."""
    with zipfile.ZipFile(built) as packed:
        content = {name: packed.read(name) for name in sorted(packed.namelist())}
    about = content["modelDescription.xml"].decode("utf-8")
    about = re.sub(r' generationDateAndTime="[^"]*"', "", about)
    about = re.sub(r'instantiationToken="[^"]*"', 'instantiationToken=""', about)
    token = uuid.uuid5(uuid.NAMESPACE_URL, about)
    content["modelDescription.xml"] = about.replace('instantiationToken=""', f'instantiationToken="{token}"').encode("utf-8")
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in content.items():
            packed.writestr(zipfile.ZipInfo(name, _TIME), data, zipfile.ZIP_DEFLATED)
