"""What all tests share: property tests draw the same examples everywhere, and do not fail because a machine is busy."""

import signal

import pytest
from hypothesis import settings

pytest_plugins = ["calibration", "processor_time"]

settings.register_profile("house", deadline=None, derandomize=True, database=None)
settings.load_profile("house")


@pytest.fixture(scope="session", autouse=True)
def heard():
    """A shell that starts the tests in the background has them ignore Ctrl-C, and all that they start."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
