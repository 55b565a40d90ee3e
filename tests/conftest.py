"""What all tests share: property tests draw the same examples everywhere, and do not fail because a machine is busy."""

from hypothesis import settings

pytest_plugins = ["calibration", "processor_time"]

settings.register_profile("house", deadline=None, derandomize=True, database=None)
settings.load_profile("house")
