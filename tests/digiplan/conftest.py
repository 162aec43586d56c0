"""A bench, and an IF1 on it that has been initialised with `U61` and is ready for instructions."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ready


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def if1(bench: Bench) -> Controller:
    return ready(bench)
