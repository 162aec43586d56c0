"""Pins, connected parts, test leads and defects."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, SensedPin, UserPin, connect


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
    end = pin.subscribe(lambda pin: seen.append(pin.level))
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
    assert levels == [True, True, False, False, True] and clock.next_event_ns() is None


def test_a_watched_flashing_pin_tells_each_edge(clock):
    pin, seen = Pin(clock, "led"), []
    pin.subscribe(lambda pin: seen.append((clock.now, pin.level)))
    pin.flash(50)
    clock.run_to(170)
    pin.set(False)
    clock.run_to(400)
    assert seen == [(0, True), (50, False), (100, True), (150, False)]


def test_a_pin_watched_while_it_flashes_already_tells_the_edges_to_come(clock):
    pin, seen = Pin(clock, "led"), []
    pin.flash(50)
    clock.run_to(60)
    pin.subscribe(lambda pin: seen.append((clock.now, pin.level)))
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
    target.subscribe(lambda pin: seen.append((clock.now, pin.level)))
    connect(source, target, delay_ns=7)
    source.set(True)
    clock.run_to(3)
    source.set(False)
    clock.run_to(20)
    assert seen == [(7, True), (10, False)]


def test_a_watched_flashing_pin_alone_leaves_the_clock_quiet(clock):
    """A flashing pin alone does not count as activity, or a bench at full speed would never become idle."""
    pin = Pin(clock, "led")
    assert clock.quiet
    pin.subscribe(lambda pin: None)
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


@pytest.fixture
def user_pin(clock):
    return UserPin(clock, "A")


def test_an_open_user_pin_is_pulled_up(user_pin):
    """Limit inputs "have 5KOhm pull-up resistors internally so a loss of connection" reads high (3.1)."""
    assert (user_pin.level, user_pin.volts, user_pin.analog) == (True, 5.0, 1023)
    assert (user_pin.driven, user_pin.is_output) == (False, False)


def test_a_test_lead_beats_the_output_stage_beats_the_wire_beats_the_pull_up(user_pin):
    user_pin.set(1.0)
    assert user_pin.volts == 1.0
    user_pin.output(True)
    assert (user_pin.volts, user_pin.is_output) == (5.0, True)
    user_pin.drive(0.5)
    assert (user_pin.volts, user_pin.driven) == (0.5, True)
    user_pin.release()
    user_pin.input()
    assert user_pin.volts == 1.0
    user_pin.set(None)
    assert user_pin.volts == 5.0


def test_a_level_is_no_voltage(user_pin):
    """`True == 1`, but a high level is 5 V and not 1 V."""
    user_pin.drive(True)
    assert user_pin.volts == 5.0
    user_pin.drive(1)
    assert user_pin.volts == 1.0
    user_pin.drive(False)
    assert user_pin.volts == 0.0
    user_pin.set(True)
    user_pin.release()
    assert user_pin.volts == 5.0


@pytest.mark.parametrize("before", [False, True])
@pytest.mark.parametrize(("volts", "level"), [
    (0.0, False), (0.8, False), (0.81, None), (1.99, None), (2.0, True), (5.0, True)])  # fmt: skip
def test_between_the_thresholds_the_level_stays(user_pin, before, volts, level):
    """1 is "2.0 Vdc or greater", 0 is "0.8 V dc" or less (6)."""
    user_pin.drive(before)
    user_pin.drive(volts)
    assert user_pin.level is (before if level is None else level)


@pytest.mark.parametrize(("volts", "number"), [
    (0.0, 0), (5.0, 1023), (2.5, 512), (1.0, 205), (0.002, 0), (0.003, 1), (4.997, 1022), (4.998, 1023),
    (5.5, 1023), (-0.5, 0)])  # fmt: skip
def test_the_converter_gives_the_nearest_of_1024_numbers(user_pin, volts, number):
    """0 is 0 V and 1023 is 5.0 V (6.3), so 2.5 V are 511.5, 1 V is 204.6, and half a step is 2.44 mV."""
    user_pin.drive(volts)
    assert user_pin.analog == number


def test_watchers_of_the_level_and_of_the_voltage(user_pin):
    levels, volts = [], []
    end = user_pin.subscribe(lambda pin: levels.append(pin.level))
    end_volts = user_pin.volts_changes.subscribe(lambda pin: volts.append(pin.volts))
    for value in (4.0, 4.0, 1.5, 0.5, False, 1.5, True):
        user_pin.drive(value)
    assert levels == [False, True] and volts == [4.0, 1.5, 0.5, 0.0, 1.5, 5.0]
    end()
    end_volts()
    user_pin.drive(False)
    assert (len(levels), len(volts)) == (2, 6)


def test_a_wire_leads_to_and_from_a_user_pin(clock, user_pin):
    lamp, button = Pin(clock, "lamp"), Pin(clock, "button")
    connect(user_pin, lamp)
    connect(button, user_pin)
    assert (user_pin.volts, lamp.level) == (0.0, False)
    button.set(True)
    assert (user_pin.volts, lamp.level) == (5.0, True)


@pytest.mark.parametrize("volts", [24, -1.0, float("nan"), float("inf")])
def test_no_voltage_that_destroys_it(user_pin, volts):
    with pytest.raises(UsageError, match="would destroy a user pin: expected 0 to 5 V"):
        user_pin.drive(volts)
    assert user_pin.volts == 5.0


def test_a_pin_tells_what_it_is_and_who_decides_about_it(clock):
    output, target = Pin(clock, "output1", output=True), Pin(clock, "input1")
    assert (output.is_output, target.is_output, target.wired, target.held) == (True, False, False, False)
    connect(output, target)
    assert target.wired
    let_go = target.hold(True)
    assert target.held
    let_go()
    assert not target.held


def test_the_level_without_test_lead_and_defects():
    clock = Clock()
    plain, user, sensed = Pin(clock, "input", True), UserPin(clock, "A"), SensedPin(clock, "Z")
    sensor = [False]
    sensed.sense(lambda: sensor[0], lambda update: lambda: None)
    for pin, free in ((plain, True), (user, True), (sensed, False)):
        pin.drive(not free)
        pin.hold(free)
        assert pin.undriven is free
    plain.set(False)
    sensor[0] = True
    assert not plain.undriven and sensed.undriven
    user = UserPin(clock, "B")
    for volts, level in ((0.5, False), (1.5, False), (3.0, True), (1.5, True), (None, True)):
        user.release()
        user.set(volts)
        user.drive(level)
        assert user.undriven is level
    user.output(False)
    assert not user.undriven
    sensed.set(False)
    assert not sensed.undriven
