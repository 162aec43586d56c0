"""The simulated NiceGUI server, which is closed after all tests of the panel, and what the tutor prints."""

import pytest

from axistwin.panel.views.asides import Asides

from .showing import stage


@pytest.fixture(scope="package", autouse=True)
def staged():
    yield
    stage.close()


@pytest.fixture
def written(monkeypatch):
    """Return the list of the texts that the tutor prints."""
    found = []

    def text(self, said, original=Asides.text):
        found.append(original(self, said))
        return found[-1]

    monkeypatch.setattr(Asides, "text", text)
    return found
