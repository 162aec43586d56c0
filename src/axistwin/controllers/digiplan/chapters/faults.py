"""Chapter Clearing fault conditions: what goes wrong is remembered until the host has asked for it.

`MotionFault` are bits of the motion status K, `LineFault` those of the communication status F, `InputBit` those of I.
"""

from collections.abc import Callable, Mapping
from enum import IntFlag
from typing import Literal

from axistwin.controllers.digiplan.chapters.motion import RampGenerator
from axistwin.sim.pins import Pin


class MotionFault(IntFlag):
    """Bits 16 to 128 of K: what inhibits motion, and the sum of the communication faults, which does not."""

    NONE = 0
    DRIVE = 16
    EMERGENCY_STOP = 32
    LIMIT = 64
    COMMUNICATION = 128


class LineFault(IntFlag):
    """Bits of F."""

    NONE = 0
    PARITY = 1
    OVERRUN = 2
    FRAMING = 4
    DATA = 8
    RANGE = 16
    LOCKED = 32


INPUT_BITS = {
    "estop": 1,
    "x_fault": 2,
    "y_fault": 4,
    "input1": 8,
    "limit_plus": 16,
    "limit_minus": 32,
    "input2": 64,
    "input3": 128,
}
"""Bits of I: 1 while no current flows in the input's opto-isolator."""

DRIVES = {"x_fault": "X", "y_fault": "Y"}
LIMITS = {"limit_plus": +1, "limit_minus": -1}
ALARMS = tuple(str(fault.name).lower() for kind in (MotionFault, LineFault) for fault in kind)
"""What the faults are called when they are told."""
CLOSED = ("estop", *LIMITS, *DRIVES)
"""Terminals through which current flows while all is well."""


class Faults:
    """The fault bits, and the lamp that shows them."""

    def __init__(self, pins: Mapping[str, Pin], show: Callable[[bool], None]) -> None:
        self.pins, self._show = pins, show
        self._inputs = [(pins[name], bit) for name, bit in INPUT_BITS.items()]
        self.motion = MotionFault.NONE
        self.line = LineFault.NONE
        self.on_fault: Callable[[str], None] = lambda name: None
        """Told of each fault when it is raised, by its name in small letters."""
        for name in DRIVES:
            self.motion |= MotionFault.NONE if pins[name].level else MotionFault.DRIVE
        if not pins["estop"].level:
            self.motion |= MotionFault.EMERGENCY_STOP
        if not all(pins[name].level for name in LIMITS):
            self.motion |= MotionFault.LIMIT

    def inputs(self) -> int:
        """The byte of the command I."""
        byte = 0
        for pin, bit in self._inputs:
            if not pin.level:
                byte |= bit
        return byte

    def status(self) -> MotionFault:
        """The fault bits of K."""
        return self.motion | MotionFault.COMMUNICATION if self.line else self.motion

    def raise_motion(self, fault: MotionFault) -> None:
        """Remember it and light the lamp."""
        self.motion |= fault
        self.show()
        self.on_fault(str(fault.name).lower())

    def raise_line(self, fault: LineFault) -> None:
        """Remember a communication fault; motion is not inhibited and the lamp stays."""
        self.line |= fault
        self.on_fault(str(fault.name).lower())

    def motion_has_been_read(self, locked: bool) -> None:
        """K or Q was answered: bits go whose cause is gone; a limit's goes at once, so that one may drive off it.

        While locked an emergency stop stays until the power is removed.
        """
        self.motion &= ~MotionFault.LIMIT
        if all(self.pins[name].level for name in DRIVES):
            self.motion &= ~MotionFault.DRIVE
        if self.pins["estop"].level and not locked:
            self.motion &= ~MotionFault.EMERGENCY_STOP
        self.show()

    def line_has_been_read(self) -> None:
        """F was answered."""
        self.line = LineFault.NONE

    def show(self) -> None:
        """The lamp: on until the bit is cleared and the input is normal again."""
        normal = all(self.pins[name].level for name in CLOSED)
        self._show(bool(self.motion) or not normal)

    def blocked(self, directions: Mapping[str, int]) -> bool:
        """Whether a move may not begin.  Towards an open limit switch it may not, and that is a limit fault again.

        A drive fault or an emergency stop whose cause is still there has not been cleared by any request.
        """
        if self.motion:
            return True
        if any(not self.pins[name].level and sign in directions.values() for name, sign in LIMITS.items()):
            self.raise_motion(MotionFault.LIMIT)
            return True
        return False


class StopInputs:
    """Emergency stop, limit switches and drive faults: a change of these inputs raises a fault and stops motion.

    `limits`: the motion that a limit switch stops when it opens.
    """

    def __init__(
        self,
        pins: Mapping[str, Pin],
        faults: Faults,
        motion: RampGenerator,
        cancel: Callable[[], None],
        limits: Literal["any motion", "motion ahead"],
    ) -> None:
        self._pins, self._faults, self._motion, self._cancel, self._limits = pins, faults, motion, cancel, limits
        self._leaving: frozenset[str] = frozenset()
        self._unwatch = [pins[name].watch(self._changed) for name in CLOSED]

    def close(self) -> None:
        """Unsubscribe from the inputs."""
        for unwatch in self._unwatch:
            unwatch()

    def may_move(self, directions: Mapping[str, int]) -> bool:
        """False if a fault or an open limit switch in one of these directions inhibits the motion.

        A limit switch that is open when a motion away from it begins does not stop that motion.
        """
        self._leaving = frozenset(name for name in LIMITS if not self._pins[name].level)
        return not self._faults.blocked(directions)

    def _changed(self, pin: Pin) -> None:
        if pin.level:
            self._faults.show()
        elif pin.name in LIMITS:
            self._limit_opened(pin.name)
        elif pin.name in DRIVES:  # the axis itself has no time to decelerate
            self._faults.raise_motion(MotionFault.DRIVE)
            self._motion.drop(DRIVES[pin.name])
            self._cancel()
        else:
            self._faults.raise_motion(MotionFault.EMERGENCY_STOP)
            self._cancel()

    def _limit_opened(self, name: str) -> None:
        """Stop motion towards the limit, and other motion too unless that motion leaves the limit."""
        self._faults.raise_motion(MotionFault.LIMIT)
        ahead = LIMITS[name] in self._motion.directions.values()
        behind = self._limits == "any motion" and name not in self._leaving
        if self._motion.running and (ahead or behind):
            self._cancel()
