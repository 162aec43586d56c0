"""A run gives the same results in any pieces, with reads in between, and compiled."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel import jit

from .pieces import Day, by_chance, watched, whole

ROOT = Path(__file__).parents[2]


@cache
def day(model="frame23"):
    """Return the record of the whole run in one piece, without reads."""
    return Day(model).live(whole)


def test_it_is_a_day_on_which_something_happens():
    said, pins, places = day()
    assert said.count("at ") == 6
    assert "followed " in said
    assert "12345\r" in said
    assert said.count("pin ") == 1
    assert {name for _, name, _ in pins} >= {"brake", "E", "F", "G", "index"}
    assert len(places) > 3000


@pytest.mark.parametrize("model", ["frame23", None])
def test_a_replay_is_identical(model):
    assert Day(model).live(whole) == day(model)


@pytest.mark.parametrize("model", ["frame23", None])
def test_looking_at_every_event_changes_nothing(model):
    assert Day(model).live(watched) == day(model)


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32), model=st.sampled_from(["frame23", None]))
def test_pieces_and_looks_change_nothing(seed, model):
    assert Day(model).live(by_chance(seed)) == day(model)


def another_process(setting):
    environment = os.environ | {"AXISTWIN_JIT": setting}
    command = [sys.executable, "-m", "tests.smartmotor.pieces"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, check=True, timeout=50)
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    "setting",
    ["off", pytest.param("on", marks=pytest.mark.skipif(not jit.available(), reason="Numba is not installed"))],
)
def test_plain_python_and_machine_code_do_the_same(setting):
    assert another_process(setting) == json.loads(json.dumps(day()))
