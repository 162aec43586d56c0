"""A run gives the same results in any pieces, with reads in between, and compiled."""

from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel import core, jit
from axistwin.controllers.smartmotor.kernel.kernel import advance

from .pieces import Day, by_chance, watched, whole


@cache
def day(model="frame23"):
    """Return the record of the whole run in one piece, without reads."""
    return Day(model).live(whole)


def test_it_is_a_day_on_which_something_happens():
    said, pins, places = day()
    assert said.count("at ") == 6 and "followed " in said
    assert "12345\r" in said and said.count("pin ") == 1
    assert {name for _, name, _ in pins} >= {"brake", "E", "F", "G", "index"}
    assert len(places) > 3000


@pytest.mark.parametrize("model", ["frame23", None])
def test_a_replay_is_identical(model):
    assert Day(model).live(whole) == day(model)


@pytest.mark.parametrize("model", ["frame23", None])
def test_looking_at_every_event_changes_nothing(model):
    assert Day(model).live(watched) == day(model)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 2**32), model=st.sampled_from(["frame23", None]))
def test_pieces_and_looks_change_nothing(seed, model):
    assert Day(model).live(by_chance(seed)) == day(model)


@pytest.mark.skipif(not jit.available(), reason="Numba is not installed")
def test_plain_python_and_machine_code_do_the_same(monkeypatch):
    days = []
    for compiled in (None, jit.best(advance)):
        monkeypatch.setattr(core.Engine, "_compiled", lambda engine, compiled=compiled: compiled)
        days.append(Day().live(whole))
    assert days[0] == days[1] == day()
