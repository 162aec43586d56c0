"""Protocol core of the Compumotor 1810 and 1811, on the text lines of a bus socket.

Each access to the board is one line: `r OFFSET [COUNT]`, `w OFFSET HH …`, `s 1` for reports of the interrupt line as
`! 1`.  Offset 0: the data buffers, 1: control and status.
"""

from collections import deque
from collections.abc import Iterable
from contextlib import suppress

from axistwin.drivers.arguments import integer, items
from axistwin.drivers.board_motor import FAIL, POLL_S, FailedError, Motor, four, signed
from axistwin.drivers.core import Core, shown
from axistwin.drivers.errors import RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.steps import Clock, Pause, Procedure, Read, Write

COMMAND_READY, RESET, INTERRUPTS, TAKEN = 0x10, 0x20, 0x40, 0x80
MESSAGE, READY, FAILED = 0x08, 0x10, 0x20
STARTUP_S = 0.1
UNDEFINED = b"\xef" * 15
"""An opcode that does not exist, with surplus bytes."""
SEVEN, STREAM_BYTES = 7, 14
"""Velocities in one command (E1h), and their bytes in the streaming buffer."""
MOTIONS = frozenset({0x11, 0x2E, 0x2F, 0x30, *range(0x32, 0x80)})
"""Commands that begin or end a motion, or define the position."""


class Board(Core):
    """Implements the protocol of an 1810 or 1811.

    The only axis is `motor`.  `interrupts`: wait for messages by the interrupt line instead of polling the status byte.
    `marker_bit`: the user bit, 0 to 2, that is set to detect a reset of the board by another program; None: no
    detection.  `home_active_high`, `home_edge_ccw`, `home_percent`: the definition of HOME (38h).
    """

    remedy = "check the board's power and the address of the bus socket (bus://)"

    def __init__(
        self, timeout: float = 1.0, *, interrupts: bool = False, marker_bit: int | None = 2,
        home_active_high: bool = True, home_edge_ccw: bool = False, home_percent: int = 10,
    ) -> None:  # fmt: skip
        super().__init__(timeout)
        if marker_bit not in (None, 0, 1, 2):
            raise ValueError(f"invalid marker_bit {marker_bit}: expected 0, 1, 2 or None")
        home_percent = integer(
            "home_percent (final velocity of a home search, in % of the default velocity)", home_percent, 1, 100
        )
        self.interrupts, self.marker_bit = interrupts, marker_bit
        self.home_definition = bytes([home_active_high, home_edge_ccw, home_percent, 0])
        self.messages: deque[bytes] = deque(maxlen=256)
        """Messages of the board that are not answers to requests, oldest first: events, alarms, markers."""
        self._known, self._lost = False, ""
        self._syncs, self._owes, self._half = 0, False, False
        """Number of synchronisations; True while a request is not answered; True while a command is not complete."""
        self._resetting = False
        """True from the call of `reset` to its beginning: a board that hangs is not asked anything before."""
        self.motor = Motor(self)
        self.axes = {"motor": self.motor}

    # Bus lines

    def _ask(self, request: str) -> Procedure[str]:
        yield Write(f"{request}\n".encode())
        while True:
            answer = (yield from self._until(b"\n", f"'{request}'")).decode("ascii", "replace").strip()
            if not answer.startswith("!"):
                break
        if answer.startswith("error"):
            raise WrongAnswerError(
                f"the answer to the bus request {request!r} is {answer!r}: expected 'ok' or hex digits, e.g. 50"
            )
        return answer

    def _read(self, count: int) -> Procedure[bytes]:
        return self._bytes((yield from self._ask(f"r 0 {count}")), count)

    def _bytes(self, answer: str, count: int) -> bytes:
        try:
            found = bytes.fromhex(answer)
        except ValueError:
            found = b""
        if len(found) != count:
            raise WrongAnswerError(
                f"the bus socket answered {shown(answer.encode())} to a read request: expected {count} hex bytes"
            )
        return found

    def _write(self, offset: int, data: Iterable[int]) -> Procedure[None]:
        answer = yield from self._ask(f"w {offset} " + " ".join(f"{value:02x}" for value in data))
        if answer != "ok":
            raise WrongAnswerError(f"the bus socket answered {shown(answer.encode())} to a write request: expected ok")

    def _control(self, bits: int) -> Procedure[None]:
        yield from self._write(1, [bits | (INTERRUPTS if self.interrupts else 0)])

    def _status_byte(self) -> Procedure[int]:
        """Read the status byte, and detect a reset or a failure of the board."""
        status = self._bytes((yield from self._ask("r 1")), 1)[0]
        if status & FAILED:
            raise FailedError(f"the 1811 has reported a failure: {FAIL.remedy}")
        if self._known and self.marker_bit is not None and status & READY and not status >> self.marker_bit & 1:
            self._known, self._lost = False, "the board was reset or its power was cut"
            yield from self._prepare()
        return status

    # Synchronisation

    def synchronise(self) -> Procedure[None]:
        """Wait until the board is ready, and discard old messages from the board; a failed board stays as it is."""
        yield from self._bus_in_step()
        if self.interrupts:
            yield from self._ask("s 1")
        resetting, self._resetting = self._resetting, False
        if not resetting:
            with suppress(FailedError):  # only `reset` leads on; each command says so
                yield from self._board_in_step()

    def _board_in_step(self) -> Procedure[None]:
        yield from self._status_until(READY, STARTUP_S)
        if self._half:
            # Surplus bytes other than 0 make the board ignore the bytes of the command that was not completed.
            yield from self._send_command(*UNDEFINED)
            yield from self._status_until(READY)
        while (yield from self._status_byte()) & MESSAGE:
            yield from self._message()
        if self._owes:
            yield from self._messages_in_step()
        if not self._known:
            yield from self._prepare()

    def _bus_in_step(self) -> Procedure[None]:
        """Discard late answers of the bus, up to the answer to a read request for an unusual number of bytes."""
        self._syncs += 1
        count = 3 + self._syncs % 12
        yield from self._discard(0.0)
        # The first line feed ends the incomplete request that an earlier host may have sent.
        request, answer = f"r 1 {count}", b""
        yield Write(f"\n{request}\n".encode())
        try:
            while len(answer.split()) != count or answer.startswith(b"error"):
                answer = yield from self._until(b"\n", f"'{request}'")
        except SilentError:
            if answer:
                raise WrongAnswerError(
                    f"the bus socket answered {shown(answer)} to the request '{request}': expected {count} hex bytes"
                ) from None
            raise

    def _messages_in_step(self) -> Procedure[None]:
        """Discard late messages, up to one with a number that the command 01h has the board send."""
        number = self._syncs % 256
        yield from self._send_command(0x01, number)
        end = (yield Clock()) + self.timeout
        while (yield Clock()) < end:
            if not (yield from self._status_byte()) & MESSAGE:
                yield Pause(POLL_S)
            elif (yield from self._message())[:2] == bytes([0x01, number]):
                self._owes = False
                return
        raise SilentError("the board does not answer the command 01h: call reset, or switch its power off and on")

    def _prepare(self) -> Procedure[None]:
        self.motor.forget()
        if self.marker_bit is not None:
            yield from self._status_until(READY)
            yield from self._send_command(0x09, self.marker_bit)
            yield from self._status_until(READY)
            # The board answers request 8Ch only after command 09h has set the marker bit of the status byte.
            yield from self._request(0x8C)
        self._known = True

    def _status_until(self, bit: int, poll: float = POLL_S) -> Procedure[None]:
        end = (yield Clock()) + self.timeout + 1.0
        while not (yield from self._status_byte()) & bit:
            if (yield Clock()) > end:
                raise SilentError("the board is not ready for a command: call reset, or switch its power off and on")
            yield Pause(poll)

    # Commands

    def command(self, opcode: int, *parameters: int) -> Procedure[None]:
        """Send a command, e.g. `command(0x0B, 1)` to set output 1."""
        message = command_bytes(opcode, *parameters)
        if opcode in MOTIONS:
            self.motor._aim(None)
        yield from self._command(*message)

    def _command(self, opcode: int, *parameters: int) -> Procedure[None]:
        yield from self._status_until(READY)
        yield from self._send_command(opcode, *parameters)

    def _send_command(self, opcode: int, *parameters: int) -> Procedure[None]:
        self._half = True
        yield from self._write(0, [opcode, *parameters])
        yield from self._control(COMMAND_READY)
        self._half = False

    def request(self, opcode: int, *parameters: int) -> Procedure[bytes]:
        """Send a request to the board, and return the board's answer: the 15 bytes after the opcode."""
        message = command_bytes(opcode, *parameters)
        yield from self._status_until(READY)
        return (yield from self._request(*message))

    def _request(self, opcode: int, *parameters: int) -> Procedure[bytes]:
        self._owes = True
        yield from self._send_command(opcode, *parameters)
        end = (yield Clock()) + self.timeout
        while True:
            if self._bytes((yield from self._ask("r 1")), 1)[0] & MESSAGE:
                message = yield from self._message()
                if message[0] == opcode:
                    self._owes = False
                    return message[1:]
                self.messages.append(message)
            elif (yield Clock()) > end:
                raise SilentError(
                    f"no answer to the request {opcode:02X}h within {self.timeout:g} s: "
                    "check the conditions for this request in the board's manual"
                )
            else:
                yield from self._wait_for_message()

    def _wait_for_message(self) -> Procedure[None]:
        if not self.interrupts:
            yield Pause(POLL_S)
        elif (yield from self._ask("i")) != "1":
            # Wait for at most 0.05 s until the server reports an interrupt of the board.
            data: bytes = yield Read(min(self.timeout, 0.05))
            self._received += data

    def _message(self) -> Procedure[bytes]:
        message = yield from self._read(16)
        yield from self._control(TAKEN)
        return message

    def take_messages(self) -> Procedure[list[bytes]]:
        """Return and clear the received messages that are not answers to requests, e.g. alarms."""
        while (yield from self._status_byte()) & MESSAGE:
            self.messages.append((yield from self._message()))
        found = list(self.messages)
        self.messages.clear()
        return found

    def reset(self) -> Procedure[None]:
        """Reset the board, which loses its position, moves and sequences."""
        self._resetting = True
        return self._reset()

    def _reset(self) -> Procedure[None]:
        self._resetting = self._half = False
        yield from self._write(1, [RESET])
        self._known, self._owes, self._lost = False, False, "the board was reset"
        yield Pause(0.01)
        yield from self._status_until(READY, STARTUP_S)
        yield from self._prepare()

    # Functions that only the boards 1810 and 1811 have

    def outputs(self, first: bool, second: bool) -> Procedure[None]:
        """Set the levels of both programmable outputs."""
        yield from self.command(0x0D, first << 1 | second << 2)

    def triggers(self) -> Procedure[dict[int, bool]]:
        """Return the signal levels at the board's trigger inputs 2 to 5."""
        bits = (yield from self.request(0x94))[0]
        return {number: bool(bits >> number & 1) for number in range(2, 6)}

    def define_sequence(self, number: int, commands: Iterable[bytes]) -> Procedure[None]:
        """Store commands as the sequence `number` (1 to 15).  `command(0x41, number)` performs the sequence."""
        number = integer("sequence", number, 1, 15)
        listed = [
            command_bytes(*items("command", one, "bytes([0x0C, 1])"))
            for one in items("commands", commands, "[bytes([0x41, 1])]")
        ]
        yield from self.motor.at_rest()  # a moving board ignores D9h, and would perform the commands
        yield from self._command(0xDA, number)
        yield from self._command(0xD9, number)
        for one in listed:
            yield from self._command(*one)
        yield from self._command(0xD8)

    def closed_loop(self, ratio: tuple[int, int], resolution: int, sigma: int, teeth: int = 50) -> Procedure[None]:
        """Set the motor pulses per encoder pulse, the encoder resolution, the backlash and the number of rotor teeth.

        `ratio`: motor pulses per encoder pulse, as a fraction.  `sigma`: the backlash.
        """
        parts = [integer("ratio", part, 0, 0xFFFF).to_bytes(2, "big") for part in items("ratio", ratio, "(4, 1)", 2)]
        numbers = [
            four(integer(what, value, 0, 2**31 - 1))
            for what, value in (("resolution", resolution), ("sigma", sigma), ("teeth", teeth))
        ]
        yield from self.command(0xB0, *b"".join(parts))
        for opcode, four_bytes in zip((0xB1, 0xB2, 0xB4), numbers, strict=True):
            yield from self.command(opcode, *four_bytes)

    def encoder(self) -> Procedure[int]:
        """Return the absolute encoder count."""
        return signed((yield from self.request(0x9A))[:4])

    def stream_times(self, update_ms: int, clock: int, divisor: int, velocities: Iterable[int]) -> Procedure[None]:
        """Run the motor at several velocities, one after the other, each for `update_ms` milliseconds.

        The commands are 52h and E1h.  A negative velocity is CCW; the last velocity must be 0.  Returns when the last
        velocities are in the buffer of about 300.  If the board has used up its buffer before the next velocities
        arrive, stops the motor and raises RefusedError.
        """
        values = [integer("velocity", one, -0x7FFF, 0x7FFF) for one in items("velocities", velocities, "[100, 0]")]
        if values[-1:] != [0]:
            raise RefusedError("invalid velocities: expected 0 as the last number, e.g. [100, 0]")
        update_ms = integer("update_ms", update_ms, 1, 0xFFFF)
        alarm = (0xFF, 0xFF, 0xFF, 0xFF)
        yield from self.command(0x52, clock, divisor, *alarm, *update_ms.to_bytes(2, "big"))
        values += [0] * (-len(values) % SEVEN)
        size = free = yield from self._free_bytes()
        begun = False
        while values:
            count = (free - 1) // STREAM_BYTES * SEVEN
            yield from self._stream(values[:count])
            del values[:count]
            if not begun:
                yield from self.command(0x42)
                self.motor.stream(update_ms)
            elif not count:
                yield Pause(update_ms * SEVEN / 1000)
            before, free = free, (yield from self._free_bytes())
            is_empty = free == size  # The board's velocity buffer has run empty.
            is_stuck = not count and free == before
            if begun and (is_empty or is_stuck):
                for kill in (0x7B, 0x78):
                    yield from self.command(kill)
                raise RefusedError(
                    "the motor was stopped, because the next velocities arrived at the board too late: "
                    "expected a larger update_ms, i.e. a longer time for each velocity"
                )
            begun = True

    def _free_bytes(self) -> Procedure[int]:
        return int.from_bytes((yield from self.request(0xE2))[2:4], "big")

    def _stream(self, values: list[int]) -> Procedure[None]:
        for begin in range(0, len(values), SEVEN):
            words = [abs(value) | (0x8000 if value < 0 else 0) for value in values[begin : begin + SEVEN]]
            yield from self.command(0xE1, *(byte for word in words for byte in word.to_bytes(2, "big")))


def command_bytes(*values: int) -> list[int]:
    """Return the bytes of a command or request: its opcode, and its parameters."""
    integer("length of a command", len(values), 1, 16)
    return [integer("byte", value, 0, 255) for value in values]
