"""The checks that every device passes, and for each check a device made wrong on purpose."""

import time
from typing import Any

import pytest

from axistwin.core.errors import UsageError
from axistwin.devices import Datagrams, Device, Lines, Option, Positioner, command, query, xor8
from axistwin.drivers import TextDriver
from axistwin.testing import device_checks, watching

from .. import campaigns
from .stages import Module, Stage

OURS = ("if1", "if2", "1810", "1811", "smartmotor")


def named(*models: Any) -> list[Any]:
    return [
        pytest.param(*check.values, id=f"{getattr(model, 'model', model)}-{check.id}")
        for model in models
        for check in device_checks(model)
    ]


@pytest.mark.parametrize("check", named(*OURS, Stage, Module))
def test_a_model_passes(check):
    check()


def failure(name: str, kind: type[Device], seed: int = 1) -> str:
    """Return what the check of this name says about a device, with the note how to repeat it."""
    (check,) = (check.values[0] for check in device_checks(kind, seed=seed) if check.id == name)
    with pytest.raises(AssertionError) as raised:
        check()
    return "\n".join([str(raised.value), *raised.value.__notes__])


class Wrong(Device):
    """What the devices below have in common, which each spoils in one way."""

    model, axes = "wrong", {"1": Positioner(velocity=2000, acceleration=20_000)}
    driver = TextDriver(move="{axis}PA{position}", stop="{axis}ST", position="{axis}TP", busy="{axis}MD")

    @command("{axis}PA{position:int}")
    def move_absolute(self, axis, position):
        self.axes[axis].move_to(position)

    @command("{axis}ST")
    def stop(self, axis):
        self.axes[axis].stop()

    @query("{axis}TP")
    def tell_position(self, axis):
        return self.axes[axis].position

    @query("{axis}MD")
    def motion_done(self, axis):
        return int(not self.axes[axis].moving)


class Echoes(Wrong):
    framing = Lines(b"\r\n", echo=True)


class Addressed(Wrong):
    framing = Lines(b"\n", address="@{number}", ignore=b"\r", ignore_case=True)
    options = {"number": Option(3, 0, 9)}


class Separates(Wrong):
    framing = Lines(b"\r", separator=b";", at_once=b"\x1b")

    @command("\x1b")
    def abort_all(self):
        for axis in self.axes.values():
            axis.abort()


class Slow(Wrong):
    answer_after = 0.05
    axes = {"1": Positioner(velocity=2000, servo=True, following_error=100)}

    def start(self):
        yield self.after(1.5)

    @command("SET[ {mode:L|R}][{value:float 0..1}]")
    def set_mode(self, mode, value):
        return "OK"


class Long(Device):
    """Datagrams with a length, and no driver."""

    model = "long"
    framing = Datagrams(">BBBh head code count value", ">BBh head code value", check=xor8, length="count")

    @command("head=170 code=1 {value:int}")
    def keep(self, value):
        self.value = value
        return {"head": 170, "code": 1, "value": value}


@pytest.mark.parametrize("kind", [Echoes, Addressed, Separates, Slow, Long])
def test_devices_with_other_framings_and_times_pass(kind):
    for check in device_checks(kind):
        if check.id in ("repeated", "distance", "reachable"):
            check.values[0]()


class Raises(Wrong):
    @command("DIV{number:int -3..3}")
    def divide(self, number):
        return 12 // number


def test_fuzz_finds_an_exception_with_its_line():
    line = Raises.divide.__code__.co_firstlineno + 2
    words = failure("fuzz", Raises)
    assert words.startswith(f"test_device_checks.py:{line}: ZeroDivisionError in wrong:")
    assert words.endswith("to repeat: device_checks('wrong', seed=1)")


class Loops(Wrong):
    @command("HUNT")
    def hunt(self):
        while not self.axes["1"].moving:
            pass


class Spins(Wrong):
    @command("HUNT")
    def hunt(self):
        while not self.axes["1"].moving:
            yield self.after(0)


@pytest.mark.parametrize("kind", [Loops, Spins])
def test_fuzz_finds_a_loop_that_never_ends(kind, monkeypatch):
    monkeypatch.setattr(watching, "PATIENCE_S", 0.3)
    words = failure("fuzz", kind)
    assert "test_device_checks.py:" in words and "never ends: let time pass in each round" in words


class Grows(Wrong):
    def start(self):
        self.errors = []

    def refused(self, reason, data):
        self.errors.append(reason.words)


def test_fuzz_finds_memory_that_grows():
    words = failure("fuzz", Grows)
    assert words.startswith("wrong grows by ") and "del self.errors[:-10]" in words


class Clock(Wrong):
    @query("TIME")
    def tell_time(self):
        return time.monotonic_ns()


def test_repeated_finds_a_clock_of_the_computer():
    assert "without time.time()" in failure("repeated", Clock)


class Speaks(Wrong):
    def start(self):
        self.clock.call_later(1_000_000_000, self.speak)

    def speak(self):
        self.send("ALIVE")
        self.clock.call_later(1_000_000_000, self.speak)


def test_power_finds_a_device_that_speaks_without_power():
    words = failure("power", Speaks)
    assert "b'A')] after the power has failed at " in words and "yield self.after()" in words


class Sulks(Wrong):
    memory = {"times": 0}

    def start(self):
        self.memory["times"] += 1
        self.save()
        if self.memory["times"] > 1:
            yield self.after(1000)


def test_power_finds_a_device_that_never_listens_again():
    assert "answers no request after the power has failed" in failure("power", Sulks)


class Pretends(Wrong):
    """A device that reports where it was told to go."""

    @query("{axis}TP")
    def tell_position(self, axis):
        return self.axes[axis].target


def test_distance_finds_a_position_that_is_not_the_machine_s():
    assert "it reports" in failure("distance", Pretends)


class Shares(Wrong):
    seen: list[str] = []

    @command("NOTE{word:word}")
    def note(self, word):
        self.seen.append(word)


class Counts(Wrong):
    made = 0

    @query("N")
    def number(self):
        Counts.made += 1
        return Counts.made


@pytest.mark.parametrize(("kind", "name"), [(Shares, "seen"), (Counts, "made")])
def test_apart_finds_what_a_class_keeps(kind, name):
    assert f"has changed the attribute {name!r} of its class" in failure("apart", kind)


class Hides(Wrong):
    framing = Lines(b"\r", separator=b";")

    @command("SET{text:text};")
    def set_text(self, text):
        self.text = text


def test_reachable_finds_a_pattern_that_the_framing_cuts():
    line = Hides.set_text.__code__.co_firstlineno
    assert failure("reachable", Hides).startswith(f"test_device_checks.py:{line}: 'SET<text>;': never reached")


def test_a_check_is_repeated_by_its_seed():
    assert failure("fuzz", Raises, 7).endswith("seed=7)")
    assert failure("power", Speaks, 3) == failure("power", Speaks, 3) != failure("power", Speaks, 4)


def test_an_unknown_model_is_refused_when_the_tests_are_collected():
    with pytest.raises(UsageError, match="no model 'stag'"):
        device_checks("stag")


@pytest.mark.slow
def test_the_campaign_with_other_seeds_finds_nothing_here():
    assert campaigns.campaign("devices").failures("1810", range(40, 42)) == []
