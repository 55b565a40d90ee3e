"""A sweep on a dask cluster; this is the one module that knows dask."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib import metadata
from importlib.util import find_spec
from typing import Any

from measure.common.errors import InputError

_PATIENCE_S = 10


@contextmanager
def connected(address: str) -> Iterator[Executor]:
    """An executor that computes on the workers of the cluster whose scheduler listens at an address.

    The scheduler gives what a dead worker had to another one.

    Raises
    ------
    InputError
        The extra is not installed, nobody answers, no worker is there, or one has another version of this project.
    """
    if find_spec("distributed") is None:
        raise InputError('--dask: the library is not installed. Install the extra: pip install "unspool[dask]".')
    from distributed import Client

    try:
        client = Client(address, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--dask {address}: no scheduler answers ({error}). Start one with dask scheduler, or check the address."
        ) from error
    with client:
        found: Any = client.run(_version)
        _require_same_version(found, address)
        with client.get_executor(pure=False) as executor:
            yield executor


def _version() -> str:
    try:
        return metadata.version("unspool")
    except metadata.PackageNotFoundError:
        return "none"


def _require_same_version(found: dict[str, str], address: str) -> None:
    """Another version may give other digits, and the same bytes are promised."""
    ours = _version()
    if not found:
        raise InputError(f"--dask {address}: no worker is there. Start one with dask worker {address}.")
    for worker, theirs in sorted(found.items()):
        if theirs != ours:
            raise InputError(
                f"--dask {address}: worker {worker} has version {theirs} of this project, and {ours} is here. Install the same."
            )
