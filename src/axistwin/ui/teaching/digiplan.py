"""Explains the commands, the replies and the state of an IF1 or IF2 to the user."""

import re
from collections.abc import Iterator

from axistwin.bench.acts import Act, Say, Wait
from axistwin.bench.programs.command_lines import ATTEMPTS, PATIENCE_S, READY_S, SELF_TEST_S, greeting
from axistwin.controllers.digiplan.chapters.data_format import read_format
from axistwin.controllers.digiplan.chapters.faults import INPUT_BITS, LIMITS, LineFault, MotionFault
from axistwin.controllers.digiplan.chapters.terminals import TERMINALS
from axistwin.controllers.digiplan.state import Stage
from axistwin.core.units import MS, to_ns
from axistwin.ui.teaching.guide import Guide, Reason, described
from axistwin.ui.teaching.remedies import at_limit

_COMMAND = re.compile(r"\D[+-]?[\d,]*|.")
_INPUT = re.compile(r"([HL])(\d)")
DRIVEN = {
    "estop": "the emergency stop is open",
    "limit_plus": "the plus limit is open: only moves in the minus direction begin",
    "limit_minus": "the minus limit is open: only moves in the plus direction begin",
    "x_fault": "the drive of X reports a fault",
    "y_fault": "the drive of Y reports a fault",
}
"""Reason why a move cannot start, for each input that must be high during a move."""


PARITIES = {"N": "no", "O": "odd", "E": "even"}


def _input_names(value: int) -> str:
    return ", ".join(f"{bit} {name}" for name, bit in INPUT_BITS.items() if value & bit)


class DigiplanGuide(Guide):
    """Explains an IF1 or IF2."""

    accepted = b"(", b"U", b"V"
    single_characters = True
    suggestions = (
        ("X1000$", "index X by 1000 steps"),
        ("X-1000@800$", "index X back, at 800 steps/s"),
        ("N", "report the position in this move"),
        ("K", "report the motion status"),
        (":X400:X-400:=2,1:$", "a sequence: forth and back, three times"),
    )

    @property
    def ready(self) -> bool:
        return self.value("state") == Stage.READY.value

    def reasons(self) -> Iterator[Reason]:
        controller = self.controller
        if not controller.powered:
            yield Reason("the power is off", self.remedies.power("on"))
            return
        if rate := list(self.line()):
            yield from rate
            return
        stage = self.value("state")
        if stage == Stage.RESET.value:
            yield Reason("the self-test takes about a second", "wait")
        elif stage == Stage.WAIT.value:
            yield Reason("the baud rate is not known yet", "type  (  and then  U61  (the data format), or  :init")
        elif stage == Stage.FORMAT.value:
            yield Reason("the data format is not known yet", "type  U61  (8 data bits, no parity), or  :init")
        if stage != Stage.READY.value:
            return
        faults = int(self.value("K")) & ~MotionFault.COMMUNICATION.value
        open_inputs = [name for name in DRIVEN if not controller.pins[name].level]
        for name in open_inputs:
            yield Reason(f"{DRIVEN[name]} ({TERMINALS[name]})", self._closed(name, faults))
        awaited = controller.awaited
        if awaited is not None:
            work, pin, level = awaited
            yield Reason(f"{work} waits for {pin} {level}", self._given(pin, level))
        locked = bool(int(self.value("F")) & LineFault.LOCKED.value)
        if faults and not open_inputs:
            yield from self._unread(MotionFault(faults), locked)
        if int(self.value("K")) & MotionFault.COMMUNICATION.value:
            yield Reason(
                f"a message was refused, and F has not been read since ({self.bits('F', int(self.value('F')))})",
                "type  F",
            )
        if locked and awaited is None:
            yield from self._locked(faults)
        port = controller.serial
        if not (port.host.dtr and port.host.rts):
            held = next((name for name in ("dsr", "cts") if port.control_lines[name].held), "")
            remedy = self.remedies.mend(held) if held else "type  :drive dtr on  and  :drive rts on"
            yield Reason("DSR or CTS is off, so the interface does not answer", remedy)

    def _closed(self, name: str, faults: int) -> str:
        read = "  and then  K" if faults else ""
        found = at_limit(self.controller, name == "limit_plus") if name in LIMITS else None
        if found is None:
            return self.restored(name, "high", then=read)
        side = "minus" if name == "limit_plus" else "plus"
        locked = int(self.value("F")) & LineFault.LOCKED.value  # A locked interface reports, but makes no moves.
        line = f"type  {']  and then  ' if locked else ''}{'K  and then  ' if faults else ''}{found[0]}{found[2]}$"
        return self.restored(
            name, "high", then=read, away=f"{found[0]} stands on the switch: move away in {side}: {line}"
        )

    def _given(self, name: str, level: str) -> str:
        pin = self.controller.pins[name]
        if pin.held or (pin.wired and not pin.driven):
            return self.restored(name, level)
        return self.remedies.drive(name, level)

    def _unread(self, faults: MotionFault, locked: bool) -> Iterator[Reason]:
        """Yield why motion stays blocked after a fault: its flags must be read with `K`, or the power cycled."""
        if locked and MotionFault.EMERGENCY_STOP in faults:
            yield Reason(
                "after an emergency stop a locked interface is reset only by its power, not by K",
                self.remedies.power("off", "on"),
            )
        elif not (locked and self._ended):
            yield Reason(f"a fault has not been read ({self.bits('Q', faults.value)})", "type  K")

    @property
    def _ended(self) -> bool:
        listing = next(iter(self.controller.programs.values()))
        return self.controller.product.model == "if2" and bool(listing.lines) and listing.running is None

    def _locked(self, faults: int) -> Iterator[Reason]:
        listing = next(iter(self.controller.programs.values()))
        if not self._ended:
            if listing.running is None:
                yield Reason("communication is locked by [", "type  ]")
            return
        ended = f"{listing.ended_by or 'its last step'} has ended the stored sequence at step {self.value('O')}"
        begins = "it begins again" if self._begins_by_itself else "send  (  and  U61,  and it begins again"
        if not faults & MotionFault.EMERGENCY_STOP.value:
            remedy = self.remedies.power("off", "on")
            yield Reason(f"{ended}, and only a power-up starts it", f"{remedy}: {begins}{self._first_wait}")
        yield Reason(
            "communication is locked by [, which keeps the sequence without power",
            "type  ]  to give up the stored sequence: the next power-off loses it, unless  [  is sent again",
        )

    @property
    def _begins_by_itself(self) -> bool:
        return not self.controller.terminals["dsr"].level

    @property
    def _first_wait(self) -> str:
        (listing,) = self.controller.programs.values()
        inputs = _INPUT.findall(listing.lines[0])
        levels = [self.remedies.drive(f"input{digit}", "high" if word == "H" else "low") for word, digit in inputs]
        return f", and waits: {' and '.join(levels)}" if levels else ""

    def answer(self, request: bytes, reply: bytes) -> str:
        text, asked = reply.rstrip(b"\r\n").decode("latin-1"), request.strip().decode("latin-1")[-1:]
        if asked == "Q" and len(reply) == 1:
            return f"{reply[0]}: {self.bits('Q', reply[0], 'at rest, no fault')}"
        if text == "U" and not self.ready:
            return "the baud rate has been measured; now the data format is expected, e.g. U61"
        if asked in ("K", "F") and text.isdecimal():
            return self._status(asked, int(text))
        if asked == "I" and text.isdecimal():
            return self._inputs(int(text))
        return self.shown(asked, text) if asked in ("E", "N", "O") else ""

    def notes(self, line: bytes) -> Iterator[str]:
        """Yield a note about a move command that does not end with the start command `$`."""
        text = line.strip().decode("latin-1")
        if text[:1] in ("X", "Y", "Z") and not text.endswith("$"):
            yield f"nothing moves without $ at the end: type  {text}$"

    def number(self, value: int) -> Iterator[str]:
        """Yield the meanings of a number: as an answer to K, to F and to I."""
        if 0 <= value <= 0xFF:
            yield f"answer to K: {self._status('K', value)}"
            yield f"answer to F: {self._status('F', value)}"
            yield f"answer to I: {self._inputs(value)}"

    def _status(self, asked: str, value: int) -> str:
        source, none = ("Q", "at rest, no fault") if asked == "K" else ("F", "no communication fault")
        return self.bits(source, value, none)

    @staticmethod
    def _inputs(value: int) -> str:
        without = _input_names(value)
        return f"no current flows in {without}" if without else "current flows in every input"

    def command(self, text: str) -> Iterator[str]:
        seen = set()
        for piece in _COMMAND.findall(text.replace(" ", "")):
            found = self.controller.product.commands.get(piece[0])
            if found is not None and piece[0] not in seen:
                seen.add(piece[0])
                yield described(found)
                yield from self._values(piece)

    def _values(self, piece: str) -> Iterator[str]:
        match piece[0]:
            case "K" | "Q":
                yield f"answer: 0 at rest, no fault; or the sum of {self.bits('Q', 0xFF)}"
            case "F":
                yield f"answer: 0 no communication fault; or the sum of {self.bits('F', 0xFF)}"
            case "I":
                yield f"answer: the sum of the inputs without current: {_input_names(0xFF)}"
            case "E":
                yield "answer: C clear, a new command is performed at once; E busy"
            case "=":
                yield "times: how often the steps are repeated after the first time; 0: endlessly"
            case "U" | "V" if (frame := read_format(piece, ord("\r" if piece[0] == "U" else "\n"))) is not None:
                size, parity, stop_bits = frame.uart
                echo = ", echo" * frame.echo + ", X-on/X-off" * frame.x_on_x_off
                stops = f"{stop_bits} stop bit{'s' * (stop_bits > 1)}"
                yield f"{piece}: {size} data bits, {PARITIES[parity]} parity, {stops}{echo}"

    def initialisation(self) -> Iterator[Act]:
        """Yield actions that send `(` until an answer arrives, and then the data format."""
        if self.value("state") == Stage.RESET.value:
            yield Wait(to_ns(SELF_TEST_S))
        _, message = greeting(self.controller.serial.host.format)
        for _ in range(ATTEMPTS):
            if self.value("state") != Stage.WAIT.value:
                break
            yield Say(b"(")
            yield Wait(to_ns(PATIENCE_S))
        if self.value("state") == Stage.FORMAT.value:
            yield Say(message)
            yield Wait(to_ns(READY_S) + 100 * MS)
