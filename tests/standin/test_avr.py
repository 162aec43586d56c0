"""Klipper's own firmware on simulated AVR boards makes the pulses that it is sent."""

import numpy as np
import pytest

from axistwin.standin.events import Failed, InputChanged, Stopped
from axistwin.standin.wiring import AxisPins, BoardPin, InputPin

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
    return Metal(board, axes=axes, inputs=inputs, outputs=(), horizon_s=horizon_s).start(1.0)


def check_edges(metal, step, times, worst_us):
    errors = metal.errors_us(step, times)
    assert np.abs(errors).max() < worst_us
    assert errors.std() < 5


def test_pulses_of_an_uno(uno):
    metal = started(uno, (UNO,), UNO_INPUTS)
    out, back = metal.even(3000, 4000), metal.even(500, 1000)
    metal.move("table.X", +1, out, 0.95)
    check_edges(metal, "PD2", out, 22)
    back = metal.even(300, 1000)
    metal.move("table.X", -1, back, 0.45)
    assert [direction for _, direction in uno.pulses["PD2"]] == [+1] * 3000 + [-1] * 300
    check_edges(metal, "PD2", back, 22)
    metal.board.stop("a human")
    metal.run(0.1)
    assert [event for event in metal.events if isinstance(event, Stopped)] == [Stopped("a human", {"table.X": 2700})]


def test_the_limit_of_an_uno_and_the_way_back(uno):
    metal = started(uno, (UNO,), UNO_INPUTS)
    times = metal.even(2000, 4000)
    metal.move("table.X", +1, times, 0.3)
    uno.set("PC0", 0)
    made = len(uno.pulses["PD2"])
    metal.move("table.X", +1, times, 0.1)
    assert len(uno.pulses["PD2"]) - made <= 1
    [stopped] = [event for event in metal.events if isinstance(event, Stopped)]
    assert stopped.by == "table.limit_plus"
    assert stopped.positions == {"table.X": len(uno.pulses["PD2"])}
    metal.board.resume("table")
    metal.move("table.X", -1, metal.even(50, 1000), 0.3)
    assert [direction for _, direction in uno.pulses["PD2"]][made + 1 :].count(-1) in (49, 50)
    uno.set("PC0", 1)
    uno.set("PC1", 0)
    metal.run(0.1)
    changes = [(event.to, event.level) for event in metal.events if isinstance(event, InputChanged)]
    assert changes[0] == ("table.limit_plus", False)
    assert set(changes[1:]) == {("table.limit_plus", True), ("table.input1", True)}


def test_silence_stops_an_uno_and_drops_its_enable(uno):
    metal = started(uno, (UNO,), UNO_INPUTS, horizon_s=0.4)
    times = metal.even(4000, 4000)
    metal.move("table.X", +1, times, 0.5)
    assert uno.levels["PB0"] == 0
    metal.alive, died = False, metal.now
    metal.run(0.3)
    assert uno.levels["PB0"] == 1
    assert uno.time_s(uno.since["PB0"]) - died < 0.12
    assert uno.time_s(uno.pulses["PD2"][-1][0]) - died < 0.12
    metal.alive = True
    metal.run(0.1)
    assert any(isinstance(event, Failed) for event in metal.events)
    metal.board.restart(metal.now)
    metal.run(0.8)
    made = len(uno.pulses["PD2"])
    assert metal.events[-1].positions == {"table.X": made}


def test_three_axes_of_a_mega():
    board = AvrBoard("atmega2560", {"PF0": "PF1", "PF6": "PF7", "PL3": "PL1"})
    try:
        metal = started(board, MEGA)
        trains = {axis.axis: metal.even(1500, 5000) + 0.000_037 * n for n, axis in enumerate(MEGA)}
        metal.move_all({axis: (+1, times) for axis, times in trains.items()}, 0.5)
        assert not [event for event in metal.events if isinstance(event, Stopped | Failed)]
        assert [len(board.pulses[step]) for step in ("PF0", "PF6", "PL3")] == [1500] * 3
        for axis in MEGA:
            check_edges(metal, axis.step.name, trains[axis.axis], 40)
    finally:
        board.close()
