"""A bench and the HAL component that advance together in virtual time; a stand-in for the step generators of HAL."""

from collections import defaultdict
from math import floor

from axistwin import Bench
from axistwin.real.standin.driver import Driver
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.component import PERIOD_S, Motion
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.wiring import DrivenAxis, Sensed, Switched

AXES = tuple(DrivenAxis(f"table.{name}") for name in "XYZ")
INPUTS = (Sensed("table.limit_plus", stops=+1), Sensed("table.estop", stops=0), Sensed("table.input1"))
OUTPUTS = (Switched("table.output1", safe=True),)


class HalTwin:
    """`pins`: those of the component; `counts`: edges of each step generator; `alive` is False after axistwin stops."""

    def __init__(self, model="if1", axes=AXES, inputs=INPUTS, outputs=OUTPUTS, closed=True, **options):
        self.now, self.alive, self.events = 10.0, True, []
        self.pins = defaultdict(float, dict.fromkeys((given.to for given in inputs), closed))
        self.steps = {axis.axis: [] for axis in axes}
        self.board = HalBoard(HalWiring("hal", axes, inputs, outputs), 0.1)
        self.motion = Motion(self.board.commands.popleft()["setup"], self.pins)
        self.bench, self.lines = Bench(), []
        self.controller = self.bench.add(model, "table", **options)
        self.driver = Driver(self.bench, [self.board], self.lines.append)
        self.driver.collected.subscribe(self.board.complete)
        self.board.commands.append({"begin": True})
        self.turn()
        if self.driver.all_ready:
            self.driver.begin(self.now)

    def turn(self):
        """Run one period of the component, and then of the step generators."""
        while self.board.commands:
            self.motion.command(self.board.commands.popleft(), self.now)
        self.motion.turn(self.now)
        for axis, steps in self.steps.items():
            at = self.pins[f"{axis}.position-fb"]
            if self.pins[f"{axis}.enable"] and (to := floor(self.pins[f"{axis}.position-cmd"] + 0.5)) != at:
                steps += [(self.now, 1 if to > at else -1)] * abs(to - int(at))
                self.pins[f"{axis}.position-fb"] = to
        while self.motion.reports:
            self.board.receive(self.motion.reports.popleft())
        while self.board.events:
            self.events.append(self.board.events.popleft())
            self.driver.handle(self.board, self.events[-1])

    def run(self, seconds):
        for tick in range(round(seconds / PERIOD_S)):
            self.now += PERIOD_S
            if self.alive:
                self.bench.run(PERIOD_S)
                if tick % 10 == 0:
                    self.driver.collect()
            self.turn()

    def say(self, text, seconds=0.2):
        self.controller.serial.write(text)
        self.run(seconds)
        return self.controller.serial.read()

    def at(self, axis="table.X"):
        return self.pins[f"{axis}.position-fb"]
