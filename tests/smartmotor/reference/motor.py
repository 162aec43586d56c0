"""Independent reference of a whole sample: program, shaft, trajectory, servo law, protection, inputs, in that order.

Each part is an object without arrays; `bridge.py` maps its attributes to slots of the processor's state.
"""

from dataclasses import dataclass, field

from .cam import Cam
from .flow import Runner
from .machine import ON, ReferenceMachine, ReferenceServo
from .program import Memory, Program
from .trajectory import Host, Master, Trajectory

FLAGS = ["Bt", "Br", "Bl", "Bi", "Bw", "Be", "Bh", "Bo", "Bx", "Bp", "Bm", "Bd", "Bu", "Bs", "Ba", "Bk"]
FREE = "off", "brake", "error", "torque"
PINS = "ABCDEFG"


def signed(value):
    """Return 32 bits with a sign."""
    return (value + 2**31) % 2**32 - 2**31


@dataclass
class Index:
    """Index marks, one per revolution of the shaft; the first mark that the shaft passes is captured."""

    at: int = 0
    turn: int = 2000
    shaft: int = 0
    below: int = 0
    """The mark below the shaft when it was last between two."""
    armed: bool = True
    forced: bool = False
    position: int = 0

    def look(self, motor):
        """Look for an index mark in this sample; return True if Bx has changed."""
        before, motor.flags["Bx"] = motor.flags["Bx"], int(self.forced or (motor.shaft - self.at) % self.turn == 0)
        if self.armed and not before and (mark := self._passed(motor.shaft)) is not None:
            self.position, self.armed, motor.flags["Bi"] = motor.direction * mark + motor.origin, False, 1
        self.shaft = motor.shaft
        if (motor.shaft - self.at) % self.turn:
            self.below = (motor.shaft - self.at) // self.turn * self.turn + self.at
        return motor.flags["Bx"] != before

    def _passed(self, shaft):
        """Return the nearest mark from the shaft's last position, excluded, to its present position, included."""
        up = (self.shaft - self.at) // self.turn * self.turn + self.turn + self.at
        down = (self.shaft - self.at - 1) // self.turn * self.turn + self.at
        return up if shaft >= up else down if shaft <= down else None


@dataclass
class GoPin:
    """Pin G: a new level counts after `debounce` samples."""

    debounce: int = 1
    level: bool = False
    different: int = 0

    def poll(self, level):
        """Sample the level; return True if the pin has gone low."""
        self.different = self.different + 1 if level != self.level else 0
        if self.different < self.debounce or level == self.level:
            return False
        self.level, self.different = level, 0
        return not level


@dataclass
class Limit:
    pin: str
    flags: tuple
    """The limit now, and what has happened."""
    way: int
    has_pin: bool = True
    acknowledged: bool = False
    soft: int = 0

    def check(self, motor):
        """Update the limit's flags; return True if the limit is a new fault."""
        beyond = self.way * motor.position >= self.way * self.soft
        asserted = (self.has_pin and motor.pins[self.pin]) or (motor.soft_limits and beyond)
        real_time, historical = self.flags
        fresh = asserted and not (motor.flags[real_time] and motor.flags[historical])
        motor.flags[real_time] = int(asserted)
        if not asserted:
            self.acknowledged = False
        return fresh or (asserted and self.way * motor.heading > 0)


@dataclass
class ReferenceMotor:
    """A motor; `data` and `load` are data sheets, and a motor without `data` is ideal."""

    program: Program
    data: object = None
    load: object = None
    overlay: bool = True
    per_sample: int = 1
    flags: dict = field(default_factory=lambda: dict.fromkeys(FLAGS, 0))
    pins: dict = field(default_factory=lambda: dict.fromkeys(PINS, False))
    values: dict = field(default_factory=dict)
    """Parameters and what else can be read and is not the kernel's: A, V, UAA …"""
    sample_number: int = 0
    clock_zero: int = 0
    rate: int = 1
    direction: int = 1
    origin: int = 0
    drive: int = ON
    torque: int = 0
    amps: int = 1023
    error_limit: int = 1000
    soft_limits: bool = False
    stopping: bool = False
    hot_limit: tuple = (70, 12_000)
    window: tuple = (-(2**62), 2**62)
    brake_pin: str = ""
    """The pin that carries the brake's signal."""
    assigning: bool = False
    brake_read: bool = False
    """An assignment has read that pin."""

    def __post_init__(self):
        self.memory = Memory(self.overlay)
        self.fetched = 0
        self.runner = Runner(self, self.program, self.per_sample)
        self.trajectory, self.master, self.cam, self.host = Trajectory(), Master(), Cam(), Host()
        self.machine = ReferenceMachine(self.data, self.load) if self.data else IdealMachine()
        self.law = ReferenceServo(self.data.tuning if self.data else (0,) * 8)
        self.plus, self.minus = Limit("C", ("Bp", "Br"), 1), Limit("D", ("Bm", "Bl"), -1)
        self.index, self.go = Index(), GoPin()

    @property
    def shaft(self):
        return self.machine.shaft

    @property
    def position(self):
        return self.direction * self.shaft + self.origin

    @property
    def heading(self):
        """Return the direction of the drive, 0 while a fault stops the motor."""
        if self.stopping:
            return 0
        return self.torque if self.trajectory.mode == "torque" else self.trajectory.velocity

    @property
    def error(self):
        return self.trajectory.place // 65536 - self.position

    def advance(self, most):
        """Compute up to `most` samples; return the reasons to stop, and shaft and commanded positions."""
        shafts, commanded, why = [], [], set()
        while not why and len(shafts) < most:
            waits = self.runner.sample()
            if waits:
                return {waits}, shafts, commanded
            why = self.sample()
            shafts.append(self.shaft)
            commanded.append(self.direction * (self.trajectory.place // 65536 - self.origin))
        return why, shafts, commanded

    def sample(self):
        """Compute one sample; return the reasons to stop."""
        self.sample_number += 1
        self.runner.left = self.per_sample
        busy = self.flags["Bt"]
        if self.data:
            self.machine.turn(self.drive, self.law.pwm)
            self.flags["Ba"] |= self.machine.over_current
            self.machine.over_current = False
        why = self._move()
        if self.data:
            self._control()
        else:
            self.machine.track(self)
        why |= self._protect() | self._inputs()
        return why | ({"trajectory"} if busy != self.flags["Bt"] else set())

    def _move(self):
        """Run trajectory and servo law in every n-th sample, where n is that of the command PIDn."""
        self.master.turn(self)
        if self.sample_number % self.rate:
            return set()
        reason = self.trajectory.move(self, self.master.counted())
        self.trajectory.wrap(self)
        return {reason} - {None}

    def _control(self):
        law = self.law
        law.rate, law.amps, law.direction = self.rate, self.amps, self.direction
        if self.drive != ON:
            law.off()
        elif self.trajectory.mode == "torque":
            law.torque(self.torque)
        else:
            law.follow(self.sample_number, signed(self.error), self.trajectory.velocity)

    def _protect(self):
        why = {name for name, limit in (("plus", self.plus), ("minus", self.minus)) if limit.check(self)}
        servo = self.drive == ON and self.trajectory.mode != "torque"
        if servo and not self.flags["Be"] and abs(self.error) > self.error_limit:
            why.add("error")
        if self.machine.temperatures.overloaded(*self.hot_limit) and not self.flags["Bh"]:
            why.add("heat")
        return why

    def _inputs(self):
        why = {"go"} if self.go.poll(self.pins["G"]) else set()
        if not self.window[0] <= self.shaft <= self.window[1]:
            why.add("switch")
        if self.index.look(self) and self.values["OBSERVE_INDEX"]:
            why.add("index")
        if self.brake_read:
            self.brake_read = False
            why.add("taken")
        return why

    def value(self, name):
        """Return a variable or a value of the motor (6)."""
        if name.islower():
            return self.memory[name]
        if name == "I":
            self.flags["Bi"], self.index.armed = 0, True
        if name[0] == "U" and name[1:2] in self.pins and name[2:] in ("", "I"):
            self.brake_read |= self.assigning and name[1] == self.brake_pin
            return int(self.pins[name[1]])
        if name in self.flags:
            return self.flags[name]
        known = self._known()
        return known[name] if name in known else self.values[name]

    def _known(self):
        word = sum(self.flags[flag] << bit for bit, flag in enumerate(FLAGS))
        return {
            "@P": signed(self.position), "@PE": signed(self.trajectory.place // 65536 - signed(self.position)),
            "@V": self.trajectory.velocity, "CLK": signed(self.sample_number - self.clock_zero), "CTR": self.master.ctr,
            "CX": self.cam.index, "I": self.index.position, "W": word, "S": word % 256,
            "U": sum(level << bit for bit, level in enumerate(self.pins.values())), "GETCHR": self.fetched,
            "D": self.cam.prepared.dwell, "F": self.cam.prepared.word, "E": self.error_limit, "T": self.torque,
        }  # fmt: skip


class IdealMachine:
    """A shaft at the commanded position; in torque mode a count for each 32 PWM units."""

    def __init__(self):
        self.shaft, self.jammed, self.brake = 0, False, False
        self.temperatures = self
        self.housing, self.hot, self.overload = 25.0, False, 0

    def track(self, motor):
        if motor.drive != ON or self.jammed:
            return
        if motor.trajectory.mode == "torque":
            torque = max(-motor.amps, min(motor.amps, motor.torque))
            self.shaft += motor.direction * (abs(torque) // 32) * (1 if torque > 0 else -1)
        else:
            self.shaft = motor.direction * (motor.trajectory.place // 65536 - motor.origin)

    def overloaded(self, limit, patience):
        return False
