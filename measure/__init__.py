"""What was seen: footage and files become tables.

from measure import Loop, Trajectory, read_loop, read_trajectory
"""

from .errors import InputError
from .tables import CHANNELS, Loop, Trajectory, read_loop, read_table, read_trajectory, write_loop, write_trajectory

__all__ = ["CHANNELS", "InputError", "Loop", "Trajectory", "read_loop", "read_table", "read_trajectory", "write_loop", "write_trajectory"]
