"""What was seen: footage and files become tables.

from measure import Loop, Trajectory, read_loop, read_trajectory
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from measure.common.errors import InputError

if TYPE_CHECKING:
    from measure.tables.tables import (
        CHANNELS,
        Loop,
        Trajectory,
        read_loop,
        read_table,
        read_trajectory,
        write_loop,
        write_trajectory,
    )

__all__ = ["CHANNELS", "InputError", "Loop", "Trajectory", "read_loop", "read_table", "read_trajectory", "write_loop", "write_trajectory"]


def __getattr__(name: str) -> Any:
    """Load the tables when one of their names is asked for; numpy behind them would delay every `--help`."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from measure.tables import tables

    return getattr(tables, name)
