"""The answers of an IF1 or IF2 beside a real one."""

import re
from collections.abc import Iterator
from typing import Any

from axistwin.controllers.digiplan.chapters.faults import INPUT_BITS, LIMITS, LineFault, MotionFault
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Accept
from axistwin.core.units import MS
from axistwin.real.shadow.dialects.dialect import Dialect, Reading, Taken, number
from axistwin.real.shadow.talk import Command, Words
from axistwin.real.shadow.twin import Twin

REQUESTS = {str(command.code): command.chapter for command in COMMANDS if Accept.REQUEST in command.accepted}
LINE_FAULTS = {
    1: "a parity error",
    2: "an overrun",
    4: "a framing error",
    8: "a data fault",
    16: "a number out of range",
}
DRIVE_PINS = ("x_fault", "y_fault")
STEPS_GRAIN = 256.0  # N counts in multiples of 256 above the start/stop speed.
OPEN = {
    "estop": "the emergency stop is open",
    "limit_plus": "the + limit is open",
    "limit_minus": "the - limit is open",
}
FORMAT, ECHOES, READY = re.compile("[UV][1-8][1-9]"), "256", "ready"
LIMIT_NS = 400 * MS  # Time within which both may stop at the same limit switch.
READY_S = 1.3  # Time for the self-test and the first ramp.


class Digiplan(Dialect):
    """E, K, Q and N change with the motion; I, K and F also say what only the machine knows."""

    needs_joining = True
    causes = ("K", "Q", "F")
    unread = ("F",)

    def __init__(self, twin: Twin) -> None:
        super().__init__(twin)
        self._words = Words(b"\r\n")
        self._echo = False
        self._limit_ns = -LIMIT_NS  # Twin's time at which the machine last reported a limit.

    def commands(self, data: bytes) -> Iterator[Command]:
        for part in data.replace(b"(", b"(\r").split(b"(\r") if b"(" in data else (data,):
            for word in self._words.receive(part):
                text = bytes(byte & 0x7F for byte in word).decode("latin-1").replace(" ", "").strip("\r\n")
                if text in REQUESTS:
                    yield Command(text, REQUESTS[text], word, answers=1)
                elif text:
                    yield _order(text, word)
                    if FORMAT.fullmatch(text) and self.twin.controller.registers["state"].read() != READY:
                        self._echo = text[2] in ECHOES

    def clear(self) -> None:
        self._words.clear()

    @property
    def echo(self) -> bool:
        return self._echo

    def read(self, command: Command | None, data: bytes) -> Reading:
        name = "" if command is None else command.name
        if name == "E":
            letter = bytes(byte & 0x7F for byte in data).strip()
            return Reading(b"ok", letter == b"E") if letter in (b"E", b"C") else Reading(letter)
        value = data[0] if name == "Q" and data else number(data)
        if value is None:
            return Reading(data)
        if name in "KQ" and name:
            return Reading(value & (0xF0 if value & 1 else ~1), bool(value & 1))
        if name == "N":
            return Reading(position=value, moving_grain=STEPS_GRAIN, ahead=True)
        if name == "O":
            return Reading(value, soft=True)
        return Reading(value)

    def take(self, command: Command, machine: bytes, twin: bytes) -> list[Taken]:
        if command.name == "E":
            return self._cleared(machine, twin)
        theirs, ours = number(machine), number(twin)
        if command.name == "Q" and machine and twin:
            theirs, ours = machine[0], twin[0]
        if theirs is None or ours is None:
            return []
        if command.name == "I" and theirs < 256:
            return list(self._inputs(theirs ^ ours, theirs))
        if command.name in "KQ" and theirs < 256:
            return list(self._motion(MotionFault((theirs ^ ours) & 0xF0), theirs))
        if command.name == "F" and theirs & ~ours & 0x1F and theirs < 64:
            names = " and ".join(text for bit, text in LINE_FAULTS.items() if theirs & ~ours & bit)
            return [Taken(f"the machine reports {names}", "F", fault=True)]
        if command.name == "F" and (theirs ^ ours) == LineFault.LOCKED.value:
            if self.twin.idle:
                self.twin.private(b"[\r" if theirs & LineFault.LOCKED.value else b"]\r")
            return [Taken("the machine is locked" if theirs & 32 else "the machine is unlocked", "lock")]
        return []

    def _cleared(self, machine: bytes, twin: bytes) -> list[Taken]:
        """The machine has no fault any more, but the twin has."""
        if twin[:1] != b"F" or machine[:1] not in (b"C", b"E"):
            return []
        for pin in ("estop", *DRIVE_PINS):
            self.twin.drive(pin, True)
        self._read_status()
        return [Taken("the machine has no fault any more", "clear")]

    @property
    def _interface(self) -> Any:
        return self.twin.controller._device._interface  # type: ignore[attr-defined]

    def halt(self) -> None:
        """Cancel beside the line, where # would be echoed, and would end what the host is just sending."""
        self._interface.work.cancel()

    def _read_status(self) -> None:
        """Clear the twin's fault bits, as the requests K and F would, which the host has made already."""
        interface = self._interface
        interface.faults.motion_has_been_read(interface.locked)
        interface.faults.line = LineFault.NONE

    def _inputs(self, bits: int, theirs: int) -> Iterator[Taken]:
        for pin, bit in INPUT_BITS.items():
            if bits & bit:
                level = not theirs & bit
                self.twin.drive(pin, level)
                if pin in LIMITS:
                    self._read_status()
                words = f"the machine says {pin} {'high' if level else 'low'}"
                fault = pin in DRIVE_PINS and not level
                yield Taken(OPEN.get(pin, words) if not level else words, pin, fault=fault, stops=pin in OPEN)

    def _motion(self, bits: MotionFault, theirs: int) -> Iterator[Taken]:
        new = MotionFault(theirs & 0xF0)
        if new & MotionFault.LIMIT:
            self._limit_ns = self.twin.now
        elif bits == MotionFault.LIMIT and self.twin.now - self._limit_ns < LIMIT_NS:
            yield Taken("both stop at a limit, the machine a little earlier", "limit", stops=True)
            return
        if bits & MotionFault.EMERGENCY_STOP:
            self.twin.drive("estop", not new & MotionFault.EMERGENCY_STOP)
            yield Taken("the machine says emergency stop", "estop", stops=True)
        if bits & MotionFault.DRIVE:
            self.twin.drive("x_fault", not new & MotionFault.DRIVE)
            yield Taken("the machine reports a drive fault", "drive", fault=True, stops=True)
        if bits & MotionFault.LIMIT & new:
            axis, direction = self.twin.busiest()
            pin = "limit_plus" if direction > 0 else "limit_minus"
            moving = self.twin.busy
            self.twin.drive(pin, False)
            self._read_status()
            if not moving:  # Otherwise the twin stands at the switch now, as the machine does.
                self.twin.drive(pin, True)
            yield Taken(f"the machine says limit, {axis}{'+' if direction > 0 else '-'}", "limit", stops=True)
        elif bits & (MotionFault.EMERGENCY_STOP | MotionFault.DRIVE | MotionFault.LIMIT):
            self._read_status()
        if bits & MotionFault.COMMUNICATION & new:
            yield Taken("the machine reports a communication fault", "F", fault=True)

    def unexplained(self, command: Command, machine: bytes) -> bool:
        return command.name == "E" and bytes(byte & 0x7F for byte in machine).strip() == b"F"

    def restarted(self, host: bytes, machine: bytes) -> bool:
        return b"(" in host and bytes(byte & 0x7F for byte in machine) == b"U\r"

    def tells(self, host: bytes, machine: bytes) -> bool:
        return host.strip() != machine.strip() or machine.strip() != b"E"  # An echo, or busy: the next answer tells.

    def join(self, host: bytes, machine: bytes) -> bool:
        """An answer to `(` comes from an interface that was switched on; any other one tells echo and terminator."""
        self.twin.power_cycle()
        self.twin.bench.run(READY_S)
        self._words.clear()
        if self.restarted(host, machine):
            self._echo = False
            self.twin.private(b"(")
            return True
        self._echo = machine.strip() == host.strip()
        letter = b"V" if host.endswith(b"\n") else b"U"
        form = letter + (b"62" if self._echo else b"61") + (b"\r\n" if letter == b"V" else b"\r")
        self.twin.private(b"(", form, seconds=READY_S)
        return False


def _order(text: str, word: bytes) -> Command:
    """Return a command that is not answered: a move, a setting, a cancel."""
    letters = [letter for letter in text if COMMANDS.get(letter) is not None and letter not in "+-,"]
    first = "$" if "$" in text else next(iter(letters), text[:1])
    chosen = next((letter for letter in letters if letter in "XYZ:SRP"), first) if first == "$" else first
    found = COMMANDS.get(chosen)
    return Command(text[:40], "" if found is None else found.chapter, word, starts="$" in text)
