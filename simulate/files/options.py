"""The options that give a command its model: a file, values changed in it, and effects of one's own."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from simulate.model.effect import Effect
    from simulate.model.model import Model


def add_effects_option(made: ArgumentParser) -> None:
    """`--effects FILE`, for every command that reads a model file."""
    what = "Python file with effects of your own; repeatable. It is run, so name only what you trust"
    made.add_argument("--effects", action="append", default=[], type=Path, metavar="FILE", help=what)


def add_model_options(made: ArgumentParser) -> None:
    """The model file, `--set KEY=VALUE` and `--effects FILE`."""
    made.add_argument("model", type=Path, metavar="MODEL", help="model file (TOML)")
    made.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value, as platform.mass_kg=0.9; repeatable")
    add_effects_option(made)


def model_from_options(given: Namespace) -> tuple[Model, Mapping[str, type[Effect]]]:
    """The model that these options give, and the catalogue with the effects of one's own.

    Raises
    ------
    InputError
        A file cannot be used, or a value cannot be.
    """
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with
    from simulate.files.settings import with_settings
    from simulate.kernel.speed_polynomials import with_rate_worked_in

    catalogue = catalogue_with(given.effects)
    of_rate = [setting for setting in given.set if setting.strip().startswith("actuator.rate")]
    model = with_rate_worked_in(with_settings(read_model(given.model, catalogue), of_rate, catalogue))
    return with_settings(model, [setting for setting in given.set if setting not in of_rate], catalogue), catalogue
