"""Chapter Clearing fault conditions: a fault is stored until the host has read the status.

The bits of `MotionFault` are reported by K, those of `LineFault` by F, and those of `INPUT_BITS` by I.
"""

from collections.abc import Callable, Mapping
from enum import IntFlag

from axistwin.controllers.digiplan.chapters.motion import RampGenerator
from axistwin.controllers.digiplan.options import Limits
from axistwin.sim.pins import Pin


class MotionFault(IntFlag):
    """Fault bits 16 to 128 of the motion status K.  All except COMMUNICATION inhibit motion."""

    NONE = 0
    DRIVE = 16
    EMERGENCY_STOP = 32
    LIMIT = 64
    COMMUNICATION = 128


class LineFault(IntFlag):
    """Bits of the communication status F."""

    NONE = 0
    PARITY = 1
    OVERRUN = 2
    FRAMING = 4
    DATA = 8
    RANGE = 16
    LOCKED = 32


INPUTS = ("estop", "x_fault", "y_fault", "input1", "limit_plus", "limit_minus", "input2", "input3")
INPUT_BITS = {name: 1 << bit for bit, name in enumerate(INPUTS)}
"""Bits of the input status I: 1 while no current flows in the input's opto-isolator."""

DRIVES = {"x_fault": "X", "y_fault": "Y"}
LIMITS = {"limit_plus": +1, "limit_minus": -1}
ALARMS = tuple(str(fault.name).lower() for kind in (MotionFault, LineFault) for fault in kind)
FAULTS = {
    "estop": MotionFault.EMERGENCY_STOP,
    **dict.fromkeys(LIMITS, MotionFault.LIMIT),
    **dict.fromkeys(DRIVES, MotionFault.DRIVE),
}
CLOSED = tuple(FAULTS)  # Terminals through which current flows in normal operation.


class Faults:
    """The fault bits and the fault lamp of the interface."""

    def __init__(self, pins: Mapping[str, Pin], show: Callable[[bool], None]) -> None:
        self.pins, self._show = pins, show
        self._inputs = [(pins[name], bit) for name, bit in INPUT_BITS.items()]
        self.motion, self.line = MotionFault.NONE, LineFault.NONE
        self.on_fault: Callable[[str], None] = lambda name: None
        """Function that is called with the name of each fault, in small letters, when the fault occurs."""
        for name in CLOSED:
            if not pins[name].level:
                self.motion |= FAULTS[name]

    def inputs(self) -> int:
        """Return the byte that the command `I` reports, with one bit for each input."""
        return sum(bit for pin, bit in self._inputs if not pin.level)

    def status(self) -> MotionFault:
        """Return the fault bits that command K reports."""
        return self.motion | MotionFault.COMMUNICATION if self.line else self.motion

    def raise_motion(self, fault: MotionFault) -> None:
        """Store a motion fault and switch the fault lamp on."""
        self.motion |= fault
        self.show()
        self.on_fault(str(fault.name).lower())

    def raise_line(self, fault: LineFault) -> None:
        """Store a communication fault, which neither inhibits motion nor lights the fault lamp."""
        self.line |= fault
        self.on_fault(str(fault.name).lower())

    def motion_has_been_read(self, locked: bool) -> None:
        """Clear the fault bits whose causes no longer exist, after an answer to K or Q.

        LIMIT is always cleared, so that the axis can leave the switch.  While locked, EMERGENCY_STOP stays set.
        """
        self.motion &= ~MotionFault.LIMIT
        if all(self.pins[name].level for name in DRIVES):
            self.motion &= ~MotionFault.DRIVE
        if self.pins["estop"].level and not locked:
            self.motion &= ~MotionFault.EMERGENCY_STOP
        self.show()

    def show(self) -> None:
        """Switch the fault lamp on if a fault bit is set or a stop input is open, otherwise off."""
        self._show(bool(self.motion) or not all(self.pins[name].level for name in CLOSED))

    def blocked(self, directions: Mapping[str, int]) -> bool:
        """True if a fault inhibits a move; towards an open limit switch, the limit fault is raised again."""
        ahead = (name for name, sign in LIMITS.items() if sign in directions.values())
        if not self.motion and not all(self.pins[name].level for name in ahead):
            self.raise_motion(MotionFault.LIMIT)
        return bool(self.motion)

    def inhibition(self, directions: Mapping[str, int]) -> str:
        """Return the faults that inhibit a move in the given directions, and the remedy."""
        faults = " and ".join(str(fault.name).lower().replace("_", " ") for fault in self.motion)
        opened = [name for name in CLOSED if not self.pins[name].level]
        stops = " and ".join(name for name in opened if name not in LIMITS)
        ahead = "".join(name for name in opened if LIMITS.get(name) in directions.values())
        first, then = f"close {stops}, then " if stops else "", f", then move away from {ahead}" if ahead else ""
        return f"the fault {faults} inhibits motion: {first}send K{then}"


class StopInputs:
    """Inputs that stop the motion and raise a fault when they open: emergency stop, limit switches and drive faults.

    `limits`: the directions of motion that an opening limit switch stops.
    """

    def __init__(self, faults: Faults, motion: RampGenerator, on_stop: Callable[[], None], limits: Limits) -> None:
        self._pins, self._faults, self._motion, self._limits = faults.pins, faults, motion, limits
        self.on_stop = on_stop
        self._leaving: frozenset[str] = frozenset()
        self._unsubscribe = [self._pins[name].subscribe(self._changed) for name in CLOSED]

    def close(self) -> None:
        """Stop observing the inputs that stop motion."""
        for unsubscribe in self._unsubscribe:
            unsubscribe()

    def may_move(self, directions: Mapping[str, int]) -> bool:
        """True unless a fault, or an open limit switch in one of these directions, inhibits the motion."""
        self._leaving = frozenset(name for name in LIMITS if not self._pins[name].level)
        return not self._faults.blocked(directions)

    def _changed(self, pin: Pin) -> None:
        if pin.level:
            self._faults.show()
            return
        self._faults.raise_motion(FAULTS[pin.name])
        if pin.name in DRIVES:
            self._motion.drop(DRIVES[pin.name])  # An axis stops without deceleration when its drive reports a fault.
        if pin.name not in LIMITS or self._limit_stops(pin.name):
            self.on_stop()

    def _limit_stops(self, name: str) -> bool:
        """True if the limit switch `name` stops the present motion.  A motion away from the switch continues."""
        ahead = LIMITS[name] in self._motion.directions.values()
        behind = self._limits == "any motion" and name not in self._leaving
        return self._motion.running and (ahead or behind)
