"""Effects of one's own, from a Python file named on the command line; they join the catalogue and work like ours."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from measure.common.errors import InputError
from measure.common.inputs import LARGEST_TOML, existing_file
from simulate.control.catalogue import add_law
from simulate.effects import CATALOGUE
from simulate.model.control import laws_among
from simulate.model.effect import Effect, effects_among


def catalogue_with(files: Iterable[Path]) -> dict[str, type[Effect]]:
    """The catalogue and the effects that these files define; laws of control that they define join the others.

    The files are run: name only such as you trust.

    Raises
    ------
    InputError
        A file cannot be run, defines no effect, or one with the name of another.
    """
    catalogue = dict(CATALOGUE)
    for file in files:
        for kind in _effects_in(Path(file)):
            if catalogue.setdefault(kind.name, kind) is not kind:
                raise InputError(f'{file}: an effect is named "{kind.name}", and there is one of that name already. Give it another.')
    return catalogue


@cache
def _effects_in(file: Path) -> list[type[Effect]]:
    existing_file(file, what="a Python file with effects", most=LARGEST_TOML)
    name = f"own_effects_{file.stem}"
    specification = importlib.util.spec_from_file_location(name, file)
    if specification is None:
        raise InputError(f"{file}: is not a Python file; name one that ends in .py.")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        exec(compile(file.read_bytes(), str(specification.origin), "exec"), vars(module))  # as an import, but it writes nothing beside it
    except Exception as error:
        raise InputError(f"{file}: could not be run: {type(error).__name__}: {error}. Mend it and try again.") from error
    found = [kind for kind in effects_among(vars(module)) if kind.__module__ == name]
    laws = [kind for kind in laws_among(vars(module)) if kind.__module__ == name]
    if not found and not laws:
        raise InputError(
            f"{file}: defines no effect and no law. Derive a frozen dataclass from simulate.model.effect.LegEffect or another, with a name."
        )
    for kind in laws:
        if add_law(kind) is not kind:
            raise InputError(f'{file}: a law is named "{kind.law}", and there is one of that name already. Give it another.')
    return found
