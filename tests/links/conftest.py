"""Fixtures: a served bench."""

from collections.abc import Iterator

import pytest

from .serving import Served


@pytest.fixture
def served() -> Iterator[Served]:
    with Served() as served:
        yield served
