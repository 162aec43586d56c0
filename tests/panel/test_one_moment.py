"""A paused bench has one value for each signal: the oscilloscope shows what lamps, registers and drawings show."""

from base64 import b64decode
from random import Random

import numpy as np
import pytest

from axistwin import Bench
from axistwin.ui.panel.scope.cursors import next_edge, value_at
from axistwin.ui.panel.scope.frames import FULL, frame
from axistwin.ui.panel.scope.recorder import Recorder
from axistwin.ui.panel.scope.screen import Screen

STARTS = {
    "if1": ("(", "U61\r", ":X40@800S1:P0,2:X-R1:=0,1:$\r"),
    "smartmotor": ("UCI UDI ZS A=100 V=400000 O=7 C1 P=P+900 G a=a+1 WAIT=99 P=P-900 G WAIT=99 GOTO1 ",),
    "1811": ("31 00 00 00 00 13 88 00 03 D0 90", "33 00 00 03 E8"),
}
SIGNALS = {
    "if1": ("if1.X.pulses", "if1.X.velocity", "if1.X.direction", "if1.output1", "if1.input1", "if1.K"),
    "smartmotor": ("motor.shaft.position", "motor.shaft.commanded", "motor.Ra", "motor.RW", "motor.A"),
    "1811": ("board.motor.pulses", "board.motor.velocity", "board.motor.direction", "board.trigger1", "board.status"),
}
NAMES = {"if1": "if1", "smartmotor": "motor", "1811": "board"}


def at_work(model):
    bench = Bench()
    controller = bench.add(model, NAMES[model])
    bench.run(1.6)
    for message in STARTS[model]:
        say(controller, message)
        bench.run(1.2 if model == "if1" else 0.01)
    recorder = Recorder()
    recorder.attach(bench)
    Screen(recorder).show(SIGNALS[model])
    return bench, recorder


def say(controller, message):
    if controller.product.model == "1811":
        for byte in bytes.fromhex(message):
            controller.bus.write(0, byte)
        controller.bus.write(1, 0x10)
    else:
        controller.serial.write(message.encode())


def elsewhere(bench, name):
    """Return the value of a signal that the other views of the page show."""
    controller, _, name = name.partition(".")
    controller = bench[controller]
    axis, _, quantity = name.rpartition(".")
    if not axis:
        return controller.read(name)
    if quantity == "direction":
        return controller.axes[axis].train.move.direction > 0
    return getattr(controller.axes[axis], "setpoint" if quantity == "commanded" else quantity)


def unequal(bench, recorder):
    """Return the signals whose newest value on the oscilloscope differs from that of other views."""
    record = recorder.catch_up()
    assert record.now_ns == bench.now
    newest = {name: value_at(track, bench.now) for name, track in record.tracks.items()}
    return {name: value for name, value in newest.items() if value != elsewhere(bench, name)}


def to_next_event(bench):
    bench.clock.run_to(bench.clock.next_event_ns())


@pytest.mark.parametrize("model", STARTS)
def test_the_newest_value_is_that_of_the_other_views(model):
    bench, recorder = at_work(model)
    chance = Random(model)
    for _ in range(100):
        if chance.random() < 0.6 and bench.clock.next_event_ns() is not None:
            to_next_event(bench)
        else:
            bench.run(chance.choice((1e-9, 1e-6, 0.0011, 0.0307)))
        assert not unequal(bench, recorder), bench.now


def test_actions_in_the_same_nanosecond_are_shown():
    bench, recorder = at_work("1811")
    board = bench["board"]
    bench.run(3.0)
    assert not unequal(bench, recorder) and not board.axes["motor"].moving
    version = recorder.version
    recorder.catch_up()
    assert recorder.version == version, "without a change, no picture is sent"

    for level in (False, True, False):
        board.pins["trigger1"].drive(level)
        assert not unequal(bench, recorder) and recorder.version > version
    say(board, "33 FF FF FC 18")
    while not board.axes["motor"].moving:
        to_next_event(bench)
        assert not unequal(bench, recorder)
    say(board, "71")  # the move is killed, in any of its nanoseconds
    for _ in range(20):
        bench.run(1e-9)
        assert not unequal(bench, recorder)
    bench.run(0.1)
    assert not unequal(bench, recorder)


def test_a_change_at_the_present_time_is_drawn_and_found():
    bench, recorder = at_work("if1")
    screen = Screen(recorder, span_ns=2000)
    screen.show(("if1.output1",))
    output = bench["if1"].pins["output1"]
    before = output.level
    while output.level is before:
        to_next_event(bench)
    recorder.catch_up()
    (signal,) = frame(screen)["signals"]
    times, values = np.frombuffer(b64decode(signal["data"]), np.uint16).reshape(-1, 2).T
    assert times[-1] == FULL and values[0] != values[-1], "the edge is at the right margin"
    assert next_edge(screen.tracks.values(), bench.now - 1000, bench.now) == bench.now
