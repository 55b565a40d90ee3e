"""MATLAB files of version 7.3 and other HDF5 files as tables, read by h5py, which is an extra.

The HDF5 library may run for ever, or fall, on a damaged file. It therefore reads in a process of its own that can be ended, and
that may not take more memory than a loop needs.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.common.limits import DECODER_BYTES
from measure.common.optional_packages import required
from measure.readers.binary_vectors import Vectors, require_size, table_of
from measure.readers.text_dialect import TextTable

_ROOT = Path(__file__).resolve().parents[2]
_PATIENCE_S = 10.0
_BYTES_A_SECOND = 5e6  # what is read of packed data on a slow machine; beyond the patience
_CALL = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]), resource.getrlimit(resource.RLIMIT_AS)[1]))
except ImportError:
    pass
from measure.readers.hdf5_child import main
raise SystemExit(main(sys.argv[2:]))
"""


def read_hdf5(path: Path) -> TextTable:
    """The data sets of an HDF5 file that share the most common length; MATLAB's structures as dotted names.

    Raises
    ------
    InputError
        h5py is not installed, a damaged file, no two vectors of one length.
    """
    required("h5py", path, "a MATLAB 7.3 or HDF5 file", "hdf5", f'save it with save("{path.name}", "-v7")')
    require_size(path)
    with np.load(io.BytesIO(_read_apart(path)), allow_pickle=False) as archive:
        about = json.loads(str(archive["about"]))
        values = {name: archive[f"v{k}"] for k, name in enumerate(about["names"])}
    return table_of(path, "HDF5", Vectors(values, about["units"], about["notes"]))


def _read_apart(path: Path) -> bytes:
    """What `measure.readers.hdf5_child` writes of a file, in a process that is ended where it takes too long."""
    patience = _PATIENCE_S + path.stat().st_size / _BYTES_A_SECOND
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    try:
        ran = subprocess.run(
            [sys.executable, "-c", _CALL, str(DECODER_BYTES), str(path.resolve())],
            env={**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            timeout=patience,
            check=False,
        )
    except subprocess.TimeoutExpired:
        sentence = f"the HDF5 library does not come to an end of it in {patience:.0f} s; it is damaged"
        raise InputError(f"{path}: {sentence}. {_again(path)}") from None
    if ran.returncode == 2:
        raise InputError(ran.stderr.decode("utf-8", "replace").strip().replace(str(path.resolve()), str(path)))
    if ran.returncode != 0:
        raise InputError(f"{path}: the HDF5 library falls over it (status {ran.returncode}); it is damaged. {_again(path)}")
    return ran.stdout


def _again(path: Path) -> str:
    return f'Save it with save("{path.name}", "-v7"), or export text.'
