"""The class KlipperBoard connected to a simulated board, in virtual time."""

import numpy as np

from axistwin.real.standin.board import State
from axistwin.real.standin.klipper import KlipperBoard
from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin, OutputPin, Wiring

from .small_board import SmallBoard

X = AxisPins("table.X", BoardPin("P2"), BoardPin("P3"), BoardPin("P4", inverted=True))
Y = AxisPins("table.Y", BoardPin("P5"), BoardPin("P6", inverted=True), BoardPin("P4", inverted=True))
LIMIT = InputPin("table.limit_plus", BoardPin("P8", pull=1), stops=+1)
INPUT = InputPin("table.input1", BoardPin("P9", inverted=True))
OUTPUT = OutputPin("table.output1", BoardPin("P10"))
TICK_S = 0.002
BLOCK = 5


class Metal:
    """A board and a simulated board that advance together; `lines` is the journal, `wire` may change bytes."""

    def __init__(self, small=None, wire=lambda data: data, horizon_s=0.1, axes=(X, Y), tick_s=TICK_S, journal=None,
                 **wiring):  # fmt: skip
        self.small, self.wire, self.lines, self.now, self.alive = small or SmallBoard(), wire, [], 10.0, True
        self.tick_s = tick_s
        self.small.levels |= {8: 1, 9: 1}
        self.small.run_to(self.now)
        made = Wiring("small", axes, wiring.pop("inputs", (LIMIT, INPUT)), wiring.pop("outputs", (OUTPUT,)), **wiring)
        self.board = KlipperBoard(made, horizon_s, journal or self.lines.append)
        self.events = []

    def run(self, seconds, each=lambda now: None):
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.now += self.tick_s
            self.small.run_to(self.now)
            each(self.now)
            if self.alive:
                for at_s, data in self.small.responses(self.now):
                    self.board.receive(self.wire(data), at_s)
                self.small.receive(self.wire(self.board.due(self.now)))
            self.events += self.board.events
            self.board.events.clear()
        return self

    def start(self, seconds=2.0):
        self.run(seconds)
        assert self.board.state is State.READY, self.events
        return self

    def move(self, axis, direction, times, seconds=None):
        """Queue pulses in blocks when they are due, as the driver does."""
        return self.move_all({axis: (direction, times)}, seconds)

    def move_all(self, trains, seconds=None):
        """Queue the pulses of several axes, given as (direction, times) for each axis."""
        sent = {axis: int(np.searchsorted(times, self.now)) for axis, (_, times) in trains.items()}

        def each(now):
            for axis, (direction, times) in trains.items():
                upto = int(np.searchsorted(times, now))
                if self.alive and upto > sent[axis] and round(now / TICK_S) % BLOCK == 0:
                    self.board.queue(axis, direction, times[sent[axis] : upto])
                    sent[axis] = upto

        last = max(times[-1] for _, times in trains.values())
        return self.run(seconds or last - self.now + 0.5, each)

    def even(self, pulses, rate):
        return self.now + np.arange(1, pulses + 1) / rate

    def errors_us(self, pin, times):
        """Return the time errors of the pulses in µs, without their constant offset."""
        made = np.array([self.small.time_s(tick) for tick, _ in self.small.pulses[pin]][-len(times) :])
        late = (made - (times + self.board.horizon_s)) * 1e6
        return late - np.median(late)
