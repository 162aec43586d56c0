"""Close the simulated NiceGUI server after all tests of the panel."""

import pytest

from .showing import stage


@pytest.fixture(scope="package", autouse=True)
def staged():
    yield
    stage.close()
