"""A bench with an 1811 that has been initialised."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ready


@pytest.fixture
def board(bench: Bench) -> Controller:
    return ready(bench)
