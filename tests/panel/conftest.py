"""The simulated NiceGUI server, which is closed after all tests of the panel."""

import pytest

from axistwin.ui.panel.memory import Memory

from .showing import stage


@pytest.fixture(scope="package", autouse=True)
def staged():
    yield
    stage.close()


@pytest.fixture(autouse=True)
def no_collection(request, monkeypatch):
    """Skip the garbage collections of a new page, which are slow in the large memory of the test process."""
    if request.path.name != "test_memory.py":
        monkeypatch.setattr(Memory, "keep", lambda self: None)
