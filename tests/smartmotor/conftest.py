"""Fixture of the motor that most tests use."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import advance, ready


@pytest.fixture
def motor(bench: Bench) -> Controller:
    """Return a SmartMotor without faults, at a whole sample."""
    made = ready(bench)
    advance(bench)
    return made
