"""A bench, and an 1811 on it that has been initialised."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ready


@pytest.fixture
def board(bench: Bench) -> Controller:
    return ready(bench)
