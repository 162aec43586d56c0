"""Klipper's firmware on simulated AVR boards makes the pulses of the step commands."""

import numpy as np
import pytest

from axistwin.real.standin.events import Failed, Stopped
from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin

from .avr_board import AvrBoard
from .metal import Metal


def pin(text):
    return BoardPin.read(text)


UNO = AxisPins("table.X", pin("PD2"), pin("PD5"), pin("!PB0"))
UNO_INPUTS = (InputPin("table.limit_plus", pin("^PC0"), stops=+1), InputPin("table.input1", pin("^!PC1")))
MEGA = tuple(
    AxisPins(f"table.{axis}", pin(step), pin(direction), pin("!PD7"))
    for axis, step, direction in (("X", "PF0", "PF1"), ("Y", "PF6", "PF7"), ("Z", "PL3", "PL1"))
)


@pytest.fixture
def uno():
    board = AvrBoard("atmega328p", {"PD2": "PD5"})
    board.set("PC0", 1)
    board.set("PC1", 1)
    yield board
    board.close()


def started(board, axes, inputs=(), horizon_s=0.1):
    return Metal(board, axes=axes, inputs=inputs, outputs=(), horizon_s=horizon_s).start(2.0)


def test_an_uno(uno):
    """Pulses in both directions, a stop by a limit switch, motion back, and a stop by the watchdog."""
    metal = started(uno, (UNO,), UNO_INPUTS)
    out = metal.even(800, 4000)
    metal.move("table.X", +1, out, 0.32)
    back = metal.even(100, 2000)
    metal.move("table.X", -1, back, 0.16)
    pulses = uno.pulses["PD2"]
    assert [direction for _, direction in pulses] == [+1] * 800 + [-1] * 100
    errors = metal.errors_us("PD2", np.concatenate([out, back]))
    assert np.abs(errors).max() < 22  # 2 µs of the host and 20 µs of the board, which also reads two inputs
    assert errors.std() < 5

    times = metal.even(800, 4000)
    metal.move("table.X", +1, times, 0.15)
    uno.set("PC0", 0)
    made = len(pulses)
    assert made > 950
    metal.move("table.X", +1, times, 0.05)
    assert len(pulses) - made <= 1
    [stopped] = [event for event in metal.events if isinstance(event, Stopped)]
    assert (stopped.by, stopped.positions) == ("table.limit_plus", {"table.X": len(pulses) - 200})

    metal.board.resume("table")
    metal.move("table.X", -1, metal.even(400, 4000), 0.14)
    metal.alive, died = False, metal.now
    metal.run(0.14)
    assert uno.levels["PB0"] == 1 and uno.time_s(uno.since["PB0"]) - died < 0.12
    assert uno.time_s(pulses[-1][0]) - died < 0.12
    metal.alive = True
    metal.run(0.05)
    assert isinstance(metal.events[-1], Failed)


def test_three_axes_of_a_mega():
    board = AvrBoard("atmega2560", {"PF0": "PF1", "PF6": "PF7", "PL3": "PL1"})
    try:
        metal = started(board, MEGA)
        trains = {axis.axis: metal.even(600, 5000) + 0.000_037 * n for n, axis in enumerate(MEGA)}
        metal.move_all({axis: (+1, times) for axis, times in trains.items()}, 0.3)
        assert not [event for event in metal.events if isinstance(event, Stopped | Failed)]
        assert [len(board.pulses[step]) for step in ("PF0", "PF6", "PL3")] == [600] * 3
        for axis in MEGA:
            assert np.abs(metal.errors_us(axis.step.name, trains[axis.axis])).max() < 22
    finally:
        board.close()
