"""The demonstration's measurements as they come from a laboratory: the film, and loops in the bench's own columns, units and commas."""

from __future__ import annotations

import shutil
from pathlib import Path

from measure.tables.loop import Loop, read_loop

_HEAD = "t;Load;Position\ns;mN;mm\n"


def write_raw(data: Path, folder: Path) -> list[Path]:
    """Write the raw files into a folder, beside what stands there.

    Parameters
    ----------
    data : the shipped data. folder : is made where it is absent.

    Raises
    ------
    InputError
        One of the files is there already.
    """
    from measure.common.errors import InputError
    from measure.common.output import write_text

    loops = sorted((data / "loops").glob("*.csv"))
    copied = [data / "film.avi", *sorted(data.glob("deployment-*.csv"))]
    made = [folder / path.relative_to(data) for path in (*copied, *loops)]
    there = [str(path) for path in made if path.exists()]
    if there:
        raise InputError(f"{', '.join(there)}: there already, and nothing is written over. Name another folder.")
    (folder / "loops").mkdir(parents=True, exist_ok=True)
    for path in copied:
        shutil.copyfile(path, folder / path.name)
    for path in loops:
        write_text(folder / "loops" / path.name, _as_the_bench_writes(read_loop(path)))
    return made


def _as_the_bench_writes(loop: Loop) -> str:
    """A loop as text: semicolons, decimal commas, force before elongation, mN and mm."""
    rows = zip(loop.time_s, 1e3 * loop.force_N, 1e3 * loop.elongation_m, strict=True)
    return _HEAD + "".join(f"{t:.7f};{force:.2f};{u:.4f}\n".replace(".", ",") for t, force, u in rows)
