"""What the tests of hostile inputs, faults and kills share."""

from __future__ import annotations

import pytest
from command_server import CommandServer
from odd_inputs import lay_out


@pytest.fixture(scope="session")
def commands():
    """The server of commands, for all tests of a process."""
    server = CommandServer("prepared_results")
    yield server
    server.close()


@pytest.fixture
def bench(tmp_path):
    """A folder with one good input of each kind."""
    folder = tmp_path / "bench"
    folder.mkdir()
    lay_out(folder)
    return folder
