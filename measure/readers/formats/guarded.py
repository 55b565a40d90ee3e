"""MATLAB, HDF5 and C3D files, workbooks and universal files, read in a process of its own.

The libraries that read them may run for ever on a damaged file, or bring the interpreter down. They therefore work in a process that
is ended after a time, and that may not take more memory than a loop needs.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from measure.common.errors import InputError
from measure.common.limits import DECODER_BYTES
from measure.common.optional_packages import required
from measure.readers.formats.vectors import Vectors, require_size, require_unpacked_zip, table_of
from measure.tables.raw_table import RawTable

_ROOT = Path(__file__).resolve().parents[3]
_PROCESSOR_S = 10
_BYTES_A_SECOND = 5e6  # what is read of packed data on a slow machine; beyond the processor time above
_WALL = 20.0  # times the processor time, on a busy machine
_CALL = """
import sys
limit, bytes_, module, file, made, part = sys.argv[1:]
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(bytes_), resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), resource.getrlimit(resource.RLIMIT_CPU)[1]))
except ImportError:
    pass
from measure.readers.formats.guarded import write_vectors
raise SystemExit(write_vectors(module, file, made, part))
"""


def read_hdf5(path: Path) -> RawTable:
    """The data sets of an HDF5 file that share the most common length; MATLAB's structures as dotted names.

    Raises
    ------
    InputError
        h5py is not installed, a damaged file, no two vectors of one length.
    """
    required("h5py", path, "a MATLAB 7.3 or HDF5 file", "hdf5", f'save it with save("{path.name}", "-v7")')
    return table_of(path, "HDF5", _read_apart(path, "measure.readers.formats.hdf5", "HDF5"))


def read_matlab(path: Path) -> RawTable:
    """The vectors of a MATLAB file up to version 7 that share the most common length; fields of structures as dotted names.

    Raises
    ------
    InputError
        Not a MATLAB file, a damaged one, no two vectors of one length.
    """
    return table_of(path, "MATLAB", _read_apart(path, "measure.readers.formats.matlab", "MATLAB"))


def read_workbook(path: Path, sheet: str | None = None) -> RawTable:
    """The table in a sheet of an Excel or OpenDocument workbook; which sheet must be said only where several hold one.

    Raises
    ------
    InputError
        python-calamine is not installed, a damaged or locked file, no table in any sheet, or one in several.
    """
    required("python_calamine", path, "a workbook", "excel", "save the sheet as text: CSV UTF-8")
    require_unpacked_zip(path)
    return table_of(path, "workbook", _read_apart(path, "measure.readers.formats.workbook", "workbook", sheet or ""))


def read_uff(path: Path) -> RawTable:
    """The functions (data sets 58) of a universal file that share the most common length, with their common abscissa.

    Raises
    ------
    InputError
        pyuff is not installed, a damaged file, no functions of one length.
    """
    required("pyuff", path, "a universal file (UFF)", "uff", "export it as text")
    return table_of(path, "universal file", _read_apart(path, "measure.readers.formats.universal_file", "universal file"))


def c3d_vectors(path: Path) -> Vectors:
    """Time and points of a C3D file; see `c3d_file.vectors`.

    Raises
    ------
    InputError
        c3d is not installed, a damaged or cut file, no rate.
    """
    required("c3d", path, "a file of markers (C3D)", "c3d", "export the markers as .trc")
    return _read_apart(path, "measure.readers.formats.c3d_file", "C3D")


def _read_apart(path: Path, module: str, kind: str, part: str = "") -> Vectors:
    """What `vectors` of a module finds in a file or a part of it, in a process that is ended where it takes too long."""
    require_size(path)
    seconds = int(_PROCESSOR_S + path.stat().st_size / _BYTES_A_SECOND)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "vectors.npz"
        words = [sys.executable, "-c", _CALL, str(seconds), str(DECODER_BYTES), module, str(path.resolve()), str(made), part]
        try:
            ran = subprocess.run(words, env=_environment(), capture_output=True, timeout=_WALL * seconds, check=False)
            status = ran.returncode
        except subprocess.TimeoutExpired:
            ran, status = None, -_OUT_OF_TIME
        if ran is not None and status == 2:
            raise InputError(ran.stderr.decode("utf-8", "replace").strip().replace(str(path.resolve()), str(path)))
        if status == -_OUT_OF_TIME:
            raise InputError(f"{path}: the {kind} library does not come to an end of it in {seconds} s; it is damaged. {again(path)}")
        if status != 0:
            raise InputError(f"{path}: the {kind} library falls over it (status {status}); it is damaged. {again(path)}")
        return Vectors.load(made)


_OUT_OF_TIME = int(getattr(signal, "SIGXCPU", 24))


_KINDS = {
    "c3d_file": "a C3D file",
    "hdf5": "HDF5",
    "matlab": "a MATLAB file",
    "workbook": "a workbook",
    "universal_file": "a universal file",
}


def _environment() -> dict[str, str]:
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}


def again(path: Path) -> str:
    """What to do with a file that its library does not read."""
    matlab = path.suffix.lower() in (".mat", ".h5", ".hdf5")
    return f'Save it with save("{path.name}", "-v7"), or export text.' if matlab else "Save it again, or export it as text."


def write_vectors(module: str, file: str, made: str, part: str = "") -> int:
    """In the process of its own: put what `vectors` of a module finds in a file into another one; a sentence and status 2 otherwise."""
    from importlib import import_module

    path = Path(file)
    try:
        import_module(module).vectors(path, *filter(None, [part])).save(Path(made))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except Exception as error:  # damaged files raise whatever the place that they are damaged at leads to
        kind = _KINDS[module.rpartition(".")[2]]
        print(f"{path}: cannot be read as {kind}: {error or type(error).__name__}. {again(path)}", file=sys.stderr)
        return 2
    return 0
