"""Columns with units and attributes as a file that keeps them: HDF5, or netCDF 3 as xarray opens it without another library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.errors import InputError
from measure.common.limits import DATASET_ENDINGS
from measure.common.output import replacing

Attribute = str | float


@dataclass(frozen=True)
class Variable:
    """A column of numbers or words along a dimension.

    values : gone through once, one at a time. attributes : such as units and long_name; a word or a number each.
    """

    dimension: str
    values: Iterable[float] | Sequence[str]
    attributes: Mapping[str, Attribute] = field(default_factory=dict)


def require_dataset_file(path: Path) -> None:
    """Refuse a name of another ending, and HDF5 where its library is missing; before any work.

    Raises
    ------
    InputError
    """
    if path.suffix not in DATASET_ENDINGS:
        raise InputError(f"{path}: a file of data ends in {' or '.join(DATASET_ENDINGS)}, HDF5 or netCDF. Name it so.")
    if path.suffix == ".h5":
        try:
            import_module("h5py")
        except ImportError as error:
            raise InputError(
                f'{path}: h5py, which writes HDF5, is not installed. Install it with pip install "unspool[hdf5]", or name a file that '
                "ends in .nc."
            ) from error


def write_dataset(
    path: Path, sizes: Mapping[str, int], variables: Mapping[str, Variable], attributes: Mapping[str, Attribute] | None = None
) -> None:
    """Write variables as HDF5 (.h5) or netCDF 3 (.nc), whole or not at all; the same values give the same bytes.

    Parameters
    ----------
    sizes : length of each dimension. variables : by name. attributes : of the file.

    Raises
    ------
    InputError
        Another ending, h5py is missing, the file cannot be written.
    """
    require_dataset_file(Path(path))
    write = _write_hdf5 if path.suffix == ".h5" else _write_netcdf
    with replacing(Path(path)) as temporary:
        write(temporary, sizes, variables, attributes or {})


def _write_hdf5(path: Path, sizes: Mapping[str, int], variables: Mapping[str, Variable], attributes: Mapping[str, Attribute]) -> None:
    h5py = import_module("h5py")
    with h5py.File(path, "w") as file:
        file.attrs.update(attributes)
        scales = {}
        for name, size in sizes.items():
            scales[name] = file.create_dataset(name, data=np.arange(size), track_times=False)
            scales[name].make_scale(name)
        for name, variable in variables.items():
            values = _filled(variable, sizes)
            shown = values.astype(h5py.string_dtype()) if values.dtype.kind == "U" else values
            made = file.create_dataset(name, data=shown, track_times=False)
            made.dims[0].attach_scale(scales[variable.dimension])
            made.attrs.update(variable.attributes)


def _write_netcdf(path: Path, sizes: Mapping[str, int], variables: Mapping[str, Variable], attributes: Mapping[str, Attribute]) -> None:
    from scipy.io import netcdf_file

    with netcdf_file(str(path), "w", version=2) as file:
        _set(file, attributes)
        for name, size in sizes.items():
            file.createDimension(name, size)
            file.createVariable(name, "i4", (name,))[:] = np.arange(size)
        for name, variable in variables.items():
            values = _filled(variable, sizes)
            dimensions: tuple[str, ...] = (variable.dimension,)
            extra: dict[str, Attribute] = {}
            if values.dtype.kind == "U":
                values = np.char.encode(values, "utf-8")
                file.createDimension(f"{name}_characters", values.dtype.itemsize)
                values = values.view("S1").reshape(len(values), -1)
                dimensions, extra = (*dimensions, f"{name}_characters"), {"_Encoding": "utf-8"}
            made = file.createVariable(name, "c" if extra else "f8", dimensions)
            made[:] = values
            _set(made, {**extra, **variable.attributes})


def _set(owner: Any, attributes: Mapping[str, Attribute]) -> None:
    for key, value in attributes.items():
        plain = value.encode("utf-8") if isinstance(value, str) else np.float64(value)  # a float of Python would be cut to single precision
        setattr(owner, key, plain)


def _filled(variable: Variable, sizes: Mapping[str, int]) -> np.ndarray:
    size = sizes[variable.dimension]
    words = isinstance(variable.values, Sequence) and bool(variable.values) and isinstance(variable.values[0], str)
    return np.array(variable.values, dtype=str) if words else np.fromiter(variable.values, float, size)
