"""Pins, what is connected to them, and who forces them."""

import pytest

from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, connect


@pytest.fixture
def clock():
    return Clock()


def test_a_test_lead_beats_what_is_connected_until_it_is_released(clock):
    pin = Pin(clock, "input1")
    pin.drive(True)
    pin.set(False)
    assert pin.level is True
    pin.release()
    assert pin.level is False


def test_watchers_are_told_of_changes_only(clock):
    pin, seen = Pin(clock, "output1"), []
    end = pin.watch(lambda pin: seen.append(pin.level))
    for level in (True, True, False, False):
        pin.set(level)
    end()
    pin.set(True)
    assert seen == [True, False]


def test_a_procedure_can_wait_for_a_change(clock):
    pin, seen = Pin(clock, "input1"), []

    def wait():
        yield pin.changed()
        seen.append((clock.now, pin.level))

    clock.process(wait())
    clock.call_later(5, lambda: pin.drive(True))
    clock.run_to(10)
    assert seen == [(5, True)]


def test_a_flashing_pin_shows_its_level_at_any_time_and_costs_no_events_unwatched(clock):
    pin = Pin(clock, "led")
    clock.run_to(100)
    pin.flash(50)
    levels = []
    for _ in range(5):
        levels.append(pin.level)
        clock.run_to(clock.now + 25)
    assert levels == [True, True, False, False, True]
    assert clock.next_event_ns() is None


def test_a_watched_flashing_pin_tells_each_edge(clock):
    pin, seen = Pin(clock, "led"), []
    pin.watch(lambda pin: seen.append((clock.now, pin.level)))
    pin.flash(50)
    clock.run_to(170)
    pin.set(False)
    clock.run_to(400)
    assert seen == [(0, True), (50, False), (100, True), (150, False)]


def test_a_pin_watched_while_it_flashes_already_tells_the_edges_to_come(clock):
    pin, seen = Pin(clock, "led"), []
    pin.flash(50)
    clock.run_to(60)
    pin.watch(lambda pin: seen.append((clock.now, pin.level)))
    clock.run_to(150)
    assert seen == [(100, True), (150, False)]


@pytest.mark.parametrize("invert", [False, True])
def test_a_wire_carries_the_level_now_and_later(clock, invert):
    source, target = Pin(clock, "a", level=True), Pin(clock, "b")
    connect(source, target, invert=invert)
    assert target.level is not invert
    source.set(False)
    assert target.level is invert


def test_a_wire_may_be_slow(clock):
    source, target, seen = Pin(clock, "a"), Pin(clock, "b"), []
    target.watch(lambda pin: seen.append((clock.now, pin.level)))
    connect(source, target, delay_ns=7)
    source.set(True)
    clock.run_to(3)
    source.set(False)
    clock.run_to(20)
    assert seen == [(7, True), (10, False)]


def test_a_watched_flashing_pin_alone_leaves_the_clock_quiet(clock):
    """Else a bench that runs as fast as it can would do nothing but flash."""
    pin = Pin(clock, "led")
    assert clock.quiet
    pin.watch(lambda pin: None)
    pin.flash(50)
    clock.step()  # the flashing begins
    assert clock.quiet
    clock.call_later(20, lambda: None)
    assert not clock.quiet
    clock.run_to(75)
    assert clock.quiet
    pin.set(False)
    clock.run_to(200)
    assert (clock.quiet, clock.next_event_ns()) == (True, None)
