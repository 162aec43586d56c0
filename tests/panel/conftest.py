"""Start NiceGUI once for all tests of the panel in this process."""

import pytest

from .showing import stage


@pytest.fixture(scope="package", autouse=True)
def staged():
    yield
    stage.close()
