"""A small instance of `benchmarks/robustness/late_answers.py`."""

import asyncio
import importlib
import sys
from pathlib import Path

import pytest

ROBUSTNESS = Path(__file__).parents[2] / "benchmarks" / "robustness"


@pytest.fixture(scope="module")
def run():
    sys.path.insert(0, str(ROBUSTNESS))
    yield importlib.import_module("late_answers").run
    sys.path.remove(str(ROBUSTNESS))


@pytest.mark.parametrize("late_s", [0.35, 2.3, 5])
@pytest.mark.parametrize("model", ["if1", "1811", "smartmotor"])
@pytest.mark.timeout(240)
def test_a_late_answer_is_not_taken_for_another(run, model, late_s):
    """These messages are of the connection, and of the beginning of the first move."""
    assert not [found for message in (10, 15, 25, 28) if (found := asyncio.run(run(model, message, 0.05, late_s)))]
