"""Reading of an 1810 or 1811: all requests, the pre-defined moves and the sequences."""

from collections.abc import Iterator

from axistwin.bench import Bench, product
from axistwin.controllers.compumotor.language import Opcode
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import MESSAGE
from axistwin.real.hosts.exchange import Exchange
from axistwin.real.probing.rescue.contents import Contents, Reader, Restoring

MODE, MOVING, MOVE, LIST, RATIO, LAW = 0x90, 0x8C, 0x91, 0x92, 0x9C, 0x9F
FENCE = b"\x01\x5a"  # Interrupt command, whose message ends the answers to the requests before it.
REQUESTS = (
    0xFD, 0x90, 0x97, 0x83, 0x9A, 0x9C, 0x9D, 0x9E, 0x9F, 0x94, 0x80, 0x81, 0x82, 0x84, 0x85, 0x86, 0x88, 0x89, 0x8A,
    0x8B, 0x8C, 0x8D, 0x8E, 0x8F, 0x93, 0x95, 0x96, 0x98, 0x99, 0x9B, 0xE2,
)  # fmt: skip
DEPENDS = frozenset((0x80, 0x81, 0x82, 0x84, 0x85, 0x86, 0x88, 0x89, 0x8A, 0x8B, 0x93, 0x95, 0x96, 0x98, 0x99, 0x9B))
"""Requests whose answers depend on the machine or on earlier motion."""
AT_ONCE = 8  # Requests that are sent before their answers are read.
MOVES, SEQUENCES = range(0, 256, AT_ONCE), range(1, 16)
INDEXER = 0x50
DEFAULT, CONTINUOUS = 0x31, 0xCE
DEFINE, END_OF_SEQUENCE = 0xD9, 0xD8
WRITE_BITS, WRITE_OUTPUTS, POSITION, ENCODER_POSITION = 0x08, 0x0D, 0x2E, 0x2F
SET_RATIO, SET_LAW = 0xB0, 0xB3
USER_BITS = "user bits"
POWER_UP_S, LONGEST_S = 2.0, 600.0
SIGNED_BITS = 32
COMMANDS = product("1811").commands
SETUP = "setup.181x"
MISSING = (
    "start/stop velocity (D6h), HOME definition (38h), rotor teeth (B4h), deadband (B5h): no request reports them",
    "interrupts (A0h to ACh), trigger functions (74h to 7Fh), state bits (0Fh): no request reports them",
    "position maintenance (18h), end of a move on stall (19h): no request reports them",
    "streamed data: no request lists the streaming buffer",
)


def read(exchange: Exchange) -> Contents:
    """Read all values, moves and sequences.  Raises LinkError if the board is silent or the motor moves."""
    _check(exchange)
    found = Contents(depends={_name(code) for code in DEPENDS}, missing=list(MISSING))
    for code in REQUESTS:
        found.values[_name(code)] = "".join(_asked(exchange, bytes((code,))))
    found.values[USER_BITS] = f"{exchange.end.user_bits:02X}"
    for first in MOVES:
        requests = (bytes((MOVE, number)) for number in range(first, first + AT_ONCE))
        for definition in _asked(exchange, *requests):
            found.values[f"move {int(definition[3:5] or '0', 16)}"] = definition
    if found.values[_name(MODE)].startswith(f"{INDEXER:02X}"):
        for number in SEQUENCES:
            listed = _asked(exchange, bytes((LIST, number)))
            if not listed:
                found.missing.append("sequences: the board does not list them, because a sequence is running: end it")
                break
            # Omit the last command of the listed sequence: a null command that only marks the end.
            if commands := listed[:-1]:
                found.values[f"sequence {number}"] = " / ".join(commands)
    return found


def _check(exchange: Exchange) -> None:
    """Raise LinkError if the board is silent or the motor moves, by 90h and 8Ch, which no sequence stores."""
    answers = {}
    for code in (MODE, MOVING):
        answer = exchange.ask(bytes((code,)), complete=lambda answer: len(answer) >= MESSAGE, patience_s=POWER_UP_S)
        if answer and answer[0] != code:
            raise LinkError(
                f"the board answers request {code:02X}h with {answer.hex(' ')}: expected {code:02x} and 15 more bytes; "
                "check --model and the data lines of the bus"
            )
        if not answer:
            raise LinkError(
                f"the board does not answer request {code:02X}h: "
                "a sequence definition may still be open; end the definition with command D8h, or reset the board"
            )
        answers[code] = answer[1]
    if answers[MOVING]:
        raise LinkError("the motor is moving: stop the motor, then run axistwin rescue again")


def _asked(exchange: Exchange, *commands: bytes) -> list[str]:
    """Send one or more requests to the board, and return the answers as hexadecimal text.

    All requests must have the same opcode.  The opcode and the zeros at the end of an answer are left out.
    """
    answer = exchange.ask(*commands, FENCE, complete=lambda answer: answer[-MESSAGE:].startswith(FENCE))
    if not answer[-MESSAGE:].startswith(FENCE):
        request = commands[0].hex(" ").upper()
        raise LinkError(
            f"the board stopped answering after request {request}: reset the board, then run axistwin rescue again"
        )
    messages = [answer[at : at + MESSAGE] for at in range(0, len(answer) - MESSAGE, MESSAGE)]
    return [_trimmed(message[1:]) for message in messages if message[0] == commands[0][0]]


def _trimmed(data: bytes) -> str:
    return (data.rstrip(b"\0") or data[:1]).hex(" ").upper()


def _name(code: int) -> str:
    return f"{code:02X}h"


def restore(contents: Contents, new: Contents) -> Restoring:
    """Return the commands that give a new board the contents, and the levels of the triggers."""
    commands = list(_commands(contents, new))
    levels = int(contents.values[_name(0x94)] or "FF", 16)
    actions = [f"trigger{number} low" for number in range(2, 6) if not levels >> number & 1]
    if not commands:
        return Restoring(actions=actions)
    lines = [f"{command.hex(' ').upper()}\n" for command in commands]
    return Restoring(actions=[*actions, f"load {SETUP}"], files={SETUP: "".join(lines)})


def _data(contents: Contents, code: int, size: int = 15) -> bytes:
    return bytes.fromhex(contents.values[_name(code)]).ljust(size, b"\0")


def _commands(contents: Contents, new: Contents) -> Iterator[bytes]:
    changed = {name: value for name, value in contents.values.items() if value not in ("", new.values.get(name))}
    if USER_BITS in changed:
        yield bytes((WRITE_BITS,)) + bytes.fromhex(changed[USER_BITS])
    if _name(0x97) in changed:
        yield bytes((WRITE_OUTPUTS, _data(contents, 0x97)[0]))
    for offset in range(LAW - RATIO + 1):
        if _name(RATIO + offset) in changed:
            size = 7 if RATIO + offset == LAW else 4
            yield bytes((SET_RATIO + offset,)) + _data(contents, RATIO + offset)[:size]
    yield from _moves(changed)
    for number in SEQUENCES:
        if text := changed.get(f"sequence {number}"):
            yield bytes((DEFINE, number))
            yield from (_exact(bytes.fromhex(command)) for command in text.split(" / "))
            yield bytes((END_OF_SEQUENCE,))
    for request, command, size in ((0x83, POSITION, 6), (0x9A, ENCODER_POSITION, 4)):
        position = int.from_bytes(_data(contents, request)[:size], "big", signed=True)
        if _name(request) in changed and position.bit_length() < SIGNED_BITS:
            yield bytes((command,)) + position.to_bytes(4, "big", signed=True)
    if _name(MODE) in changed:
        yield _data(contents, MODE).rstrip(b"\0")


def _moves(changed: dict[str, str]) -> Iterator[bytes]:
    for number in range(256):
        if text := changed.get(f"move {number}"):
            definition = bytes.fromhex(text)
            if number == 0:
                yield bytes((DEFAULT, 0)) + definition[2:11].ljust(9, b"\0")
            else:
                yield _exact(definition)


def _exact(command: bytes) -> bytes:
    known = COMMANDS.get(command[0])
    return known.string(command[1:].ljust(MESSAGE, b"\0")) if isinstance(known, Opcode) else command


def start(bench: Bench, _: Contents) -> None:
    bench.run(POWER_UP_S)
    for process in bench.senders.values():
        bench.run_until(lambda: not process.is_alive, LONGEST_S)  # noqa: B023  # called at once


READER = Reader(read, restore, start)
