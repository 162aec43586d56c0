"""Cases for the 1810 and 1811.  Commands are sent as bytes; answers are messages of 16 bytes."""

import re
from collections.abc import Callable, Mapping

from axistwin.bench import Controller
from axistwin.controllers.compumotor.language import Opcode
from axistwin.controllers.product import Product
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import LATE_S, MESSAGE, End
from axistwin.real.probing.cases import Case, Condition, Dialect, around, connect

WRITE_BITS, SET_BIT, CLEAR_BIT = USER_BITS = (0x08, 0x09, 0x0A)
MOVE, TOO_HIGH = 0x32, 0xC0  # The move that the cases define and delete, which must be free; above 32h none is stored.
MOVE_PARAMETERS, MODE, MOVING, FREE, PART = 0x91, 0x90, 0x8C, 0xE2, 0xFD
LISTS = 0x92
DEFINITIONS = (0xC8, 0xCB, 0xCE)
DELETE, DEFAULTS, ECHO = 0xD7, 0x31, 0x01
INDEXER = 0x50
STREAMED = 16  # Bytes of a command with streamed distances.
STATUS = b""  # Request for the user bits, which the host reads without a command.
BACK = ("34 00 00 00 00", "00", "00", "00", "00", "33 00 00 00 0A", "00", "33 FF FF FF F6", "00")
"""Return to the absolute zero after a run, whose length depends on the host's time; the last move is then known."""
UNDEFINED = (0x02, 0x07, 0x16, 0x1F, 0x5F, 0x6A, 0xBA, 0xC0, 0xF0, 0xFC)


def cases(product: Product, _: Mapping[str, str]) -> list[Case]:
    commands = {command.opcode: command for command in product.commands if isinstance(command, Opcode)}
    return [
        *_requests(commands), *_bits(commands), *_definitions(commands), *_ignored(commands), *_moves(commands),
        *_plugged(commands), *_bare(commands),
    ]  # fmt: skip


def _asked(code: int) -> bool:
    return 0x80 <= code <= 0x9F or code in (FREE, PART)


def _requests(commands: dict[int, Opcode]) -> list[Case]:
    found = []
    for code, command in filter(lambda item: _asked(item[0]), commands.items()):
        section, name = command.chapter, f"{code:02X}h {command.name}"
        if command.parameters:
            numbers = (0, 1, MOVE, TOO_HIGH, 255) if code == MOVE_PARAMETERS else (1, 15)
            found += [Case(f"{name} {number}", section, (bytes((code, number)),), depends=True) for number in numbers]
            found.append(Case(f"{name} without a number", section, (bytes((code,)), bytes((ECHO, code)))))
            continue
        found += [
            Case(name, section, (bytes((code,)),), depends=code != PART),
            Case(f"{name}, followed by 00", section, (bytes((code, 0, 0)),), depends=code != PART),
            Case(f"{name}, followed by 01", section, (bytes((code, 1)), bytes((ECHO, code)))),
        ]
    return found


def _bits(commands: dict[int, Opcode]) -> list[Case]:
    section = commands[ECHO].chapter
    found = [Case(f"01h interrupt {value}", section, (bytes((ECHO, value)),)) for value in (0, 1, 0x55, 0xFF)]
    for code in USER_BITS:
        command = commands[code]
        (parameter,) = command.fields
        for words, value in around(parameter.low, parameter.high).items():
            if 0 <= value <= 0xFF:
                before = bytes((WRITE_BITS, 0x00 if code == SET_BIT else 0x07))
                says = (before, bytes((code, value)), STATUS, b"\x97")
                name = f"{code:02X}h {command.name}: {words}, {value}"
                found.append(Case(name, command.chapter, says, writes=True, depends=True))
    return found


def _definitions(commands: dict[int, Opcode]) -> list[Case]:
    found = []
    ask = bytes((MOVE_PARAMETERS, MOVE))
    gone = bytes((DELETE, MOVE))
    for code in DEFINITIONS:
        command = commands[code]
        values = {
            "legal": (0x00, 1000, 10_000, 250),
            "velocity 0": (0x00, 0, 10_000, 250), "acceleration 0": (0x00, 500, 0, 250),
            "other ranges": (0x11, 100, 100, -250), "a wrong velocity range": (0x60, 100, 100, 250),
            "a wrong acceleration range": (0x03, 100, 100, 250), "a negative velocity": (0x00, -1, 100, 250),
            "the greatest distance": (0x00, 1000, 10_000, 0x7FFF_FFFF),
            "the least distance": (0x00, 1000, 10_000, -0x8000_0000),
        }  # fmt: skip
        for words, (ranges, velocity, acceleration, distance) in values.items():
            numbers = b"".join(number.to_bytes(4, "big", signed=True) for number in (velocity, acceleration))
            last = bytes((distance & 1,)) if code == DEFINITIONS[2] else distance.to_bytes(4, "big", signed=True)
            says = (gone, bytes((code, MOVE, ranges)) + numbers + last, ask, gone, ask)
            name = f"{code:02X}h {command.name}: {words}"
            found.append(Case(name, command.chapter, says, writes=True, timed=False))
        short = (gone, bytes((code, MOVE)), ask)
        found.append(Case(f"{code:02X}h {command.name}: too short", command.chapter, short, writes=True))
    return found


def _ignored(commands: dict[int, Opcode]) -> list[Case]:
    section = commands[0].chapter
    found = [Case("00h null", section, (b"\0", b"\x01\x07"))]
    return found + [
        Case(f"{code:02X}h, undefined", section, (bytes((code,)), bytes((ECHO, code))))
        for code in UNDEFINED
        if code not in commands
    ]


def _moves(commands: dict[int, Opcode]) -> list[Case]:
    asks = tuple(bytes((code,)) for code in (0x80, 0x81, 0x82, 0x83, 0x84, 0x85, 0x86, 0x88, 0x89, 0x8C))

    def case(code: int, *texts: str, wait_s: float = 0.4, name: str = "") -> Case:
        command = commands[code]
        says = (*(bytes.fromhex(text) for text in texts), *asks)
        words = f"{code:02X}h {name or command.name}"
        return Case(words, command.chapter, says, moves=True, writes=True, wait_s=wait_s)

    def run(*texts: str, name: str) -> Case:
        # The host stops this move at a varying time, so the test case does not request the final position.
        says = (*(bytes.fromhex(text) for text in texts), *(bytes((code,)) for code in (0x84, 0x86, 0x89, 0x8C)))
        return Case(name, commands[0x32].chapter, says, moves=True, writes=True, wait_s=0.4)

    there, back = "33 00 00 00 C8", "33 FF FF FF 38"
    return [
        Case("outputs low", commands[0x0D].chapter, (b"\x0d\0",), moves=True, writes=True, plug=True),
        case(0x31, "31 00 00 00 00 03 E8 00 00 27 10", "33 00 00 00 07", "30", "83", "9A"),
        case(0x2F, "2F 00 00 00 07", "9A", "30", "9A"),
        case(0x33, "33 00 00 00 32", "33 FF FF FF CE"),
        case(0x34, "34 00 00 00 28", "34 00 00 00 00"),
        case(0x40, "C8 C0 00 00 00 03 E8 00 00 27 10 00 00 00 32", "40 C0", name="a number above 32h"),
        case(0x40, "C8 32 00 00 00 03 E8 00 00 27 10 00 00 00 32", "40 32", "91 32"),
        case(0xCB, "CB 32 00 00 00 03 E8 00 00 27 10 00 00 00 05", "40 32", "91 32"),
        case(0xD6, "A5 01", "D6 00 00 01 2C", "33 00 00 00 64", "33 FF FF FF 9C", "D6 00 00 00 00", "A5 00"),
        case(0xD6, "A5 01", "D6 00 00 01 2C", "31 00 00 00 00 03 E8 00 00 00 64", "33 00 00 00 64", "33 FF FF FF 9C",
             "D6 00 00 00 00", "31 00 00 00 00 03 E8 00 00 27 10", "A5 00", name="a slow ramp from the start velocity"),
        case(0x2E, "2E 00 00 03 E8", "33 00 00 00 0A"),
        case(0xD9, "D9 0F", "33 00 00 00 0A", "29 00 00 07 D0", "33 FF FF FF F6", "D8", "92 0F", "41 0F"),
        case(0x79, "79", "DA 0F"),
        case(0x20, "D9 0F", "20 01 00 03", "33 00 00 00 05", "D8", "92 0F", "41 0F", "DA 0F", "92 0F"),
        case(0x94, "94", "0D 06", "97", "0C 01", "97", "0B 01", "97", "0C 02", "97", "0B 02", "97", "0D 00",
             name="triggers and outputs"),
        case(0xB0, "9C", "B0 00 02 00 01", "9C", "B0 00 01 00 01", "9C", name="ratio"),
        case(0xB1, "9D", "B1 00 00 03 E8", "9D", "B1 00 00 61 A8", "9D", name="motor resolution"),
        case(0xB2, "9E", "B2 00 00 00 05", "9E", "B2 00 00 00 00", "9E", name="backlash sigma"),
        case(0x14, "14 01", "33 00 00 00 14", "14 00", "33 00 00 00 14", name="sense of CW"),
        case(0x0D, "0D 01", "97", "0D 02", "97", "0D 00", "97"),
        *(
            # Each null command 00h gives the motor 0.4 s more to finish its move.
            case(code, f"{code:02X} 01", there, "00", back, "00", f"{code:02X} 00", "33 00 00 00 14")
            for code in range(0xA0, 0xA6)
        ),
        case(0xAF, "A1 01", "AF", "33 00 00 00 14", "A1 00"),
        *_sequences(case),
        *_streams(case),
        *_shown_elsewhere(case, commands),
        run("32 00", "70", name="32h go on, then stop"),
        run("32 01", "78", name="32h go on the other way, then kill"),
        run("CE 32 00 00 00 00 64 00 00 27 10 00", "40 32", "91 32", "70", "D7 32", name="CEh continuous move"),
    ]  # fmt: skip


def _shown_elsewhere(case: Callable[..., Case], commands: dict[int, Opcode]) -> list[Case]:
    """Return test cases for the settings of the board that the host can write but not read.

    Each test case sends a setting, then checks the reaction of the board by a request or by the user bits.
    """
    return [
        case(0x0F, "30", "0F 00 01 01", "", "32 00", "", "78", "", "0F 00 00 01", "08 00", "", "0F 03 01 00", "97",
             "32 00", "97", "78", "0F 03 00 00", "0D 06", "97", "0D 00", *BACK, name="a bit that shows motion",
             wait_s=0.1),
        *(
            case(code, "0F 00 80 01", "", "B5 00 00 00 05", "", "0F 00 00 01", "08 00")
            for code in {0xB5} & commands.keys()
        ),
        case(0x18, "18 01", "33 00 00 00 0A", "80", "18 00", "33 FF FF FF F6"),
        case(0x38, "38 01 00 32 00", "8A", "38 00 00 32 00", "8A"),
        case(0xB3, "B3 01 05 00 00 00 10 00", "9F"),
        case(0xB4, "B0 00 01 00 01", "B1 00 00 61 A8", "B4 00 00 00 32", "2E 00 0F 42 40", "9B", "2E 00 00 00 00"),
        case(0xD4, "D4 32 00 00 00 03 E8 00 00 27 10 00 00 00 05", "91 32", "D7 32"),
        case(0xD5, "D5 32 00 00 00 03 E8 00 00 27 10 00 00 00 05", "91 32", "D7 32"),
        case(0x73, "30", "31 00 00 00 00 01 F4 00 00 27 10", "33 00 00 01 2C", "73", "8D", "00", "00", "00", "8C",
             "78", *BACK, wait_s=0.2),
    ]  # fmt: skip


def _sequences(case: Callable[..., Case]) -> list[Case]:
    def sequence(code: int, *texts: str, then: tuple[str, ...] = (), name: str = "", wait_s: float = 0.4) -> Case:
        return case(code, "D9 0F", *texts, "01 07", "D8", "41 0F", *then, "79", "DA 0F", name=name, wait_s=wait_s)

    wait, go_on = "29 00 00 00 C8", "48"
    return [
        sequence(0x20, "20 01 00 03", "29 00 00 00 1E"), sequence(0x21, "21 01", "29 00 00 00 1E", then=(go_on,)),
        sequence(0x28, "28 01", then=(go_on,)),
        sequence(0x28, "28 00", then=(go_on,), name="wait for continue, without a message"), sequence(0x29, wait),
        sequence(0x2A, "2A 00 01", wait_s=1.5), sequence(0x2B, "2B 00 01", then=("79",)),
        sequence(0x2C, "2C 02 01", name="wait for a high level of trigger 2"),
        sequence(0x2C, "2C 02 00", name="wait for a low level of trigger 2"),
        sequence(0x71, wait, then=("71", "88", "88", "88", "88"), wait_s=0.05),
        sequence(0x72, wait, then=("72", "88", "88", "88", go_on), wait_s=0.1),
        sequence(0x7A, wait, then=("7A", "88", "88", go_on), wait_s=0.1),
        sequence(0x79, wait, then=("79", "88", "88"), wait_s=0.1),
        sequence(0xDA, wait, then=("DA 0F", "92 0F", "41 0F"), wait_s=0.4),
    ]  # fmt: skip


def _streams(case: Callable[..., Case]) -> list[Case]:
    """Return test cases that stream a few pulses to the motor; each stream ends at standstill."""
    mode, there, back = "53 03 10 00 00 00 00 00 64", "E3 01 00 05", "E3 02 FF FB 00 00"
    zeros = " 00" * 14
    velocities = "E0 00 10 00 02 80 10 00 02 00 00 00 01"

    def stream(code: int, *texts: str, name: str = "", wait_s: float = 0.4, then: tuple[str, ...] = ()) -> Case:
        padded = (text + zeros[: 3 * (STREAMED - len(text.split()))] if text[:2] == "E3" else text for text in texts)
        return case(code, *padded, "78", "50", "90", *then, name=name, wait_s=wait_s)

    return [
        stream(0x51, "51 09 10 00 00 00 10", "90", velocities, "E2", "42", "E2"),
        stream(0x52, "52 09 10 00 00 00 10 00 64", "90", "E1 00 10 80 10" + zeros[:30], "E2", "42"),
        stream(0x53, mode, "90", "E3 03 00 05 FF FB 00 00", "E2", "42", "80"),
        stream(0xE3, mode, "E3 04 00 05 00 00 FF FB 00 00", "42", "83", "00", "00", wait_s=0.15),
        stream(0xEE, mode, "EE 7F FF 01 07 00", there, "E3 02 7F FF 00 00", back, "42", name="a marker in the stream"),
        stream(
            0xE3,
            mode,
            "E3 07 00 01 00 02 00 03 00 02 00 01 FF FB FF FC",
            "E3 01 00 00",
            "42",
            "83",
            name="seven steps",
            wait_s=1.0,
        ),
        stream(
            0x70,
            "51 09 10 00 00 00 10",
            "E0 00 10 00 02 00 10 00 02 00 10 00 02",
            "42",
            "8C",
            "70",
            "8C",
            name="stop after a stream",
        ),
        stream(0xEE, mode, there, "EE 00 01 01 07 00", back, "42"),
        stream(0x7B, mode, there, "E2", "7B", "E2"),
        stream(0x7B, "30", mode, there, back, "42", "7B", "E2", name="kill streaming buffer, during the stream",
               wait_s=0.05, then=BACK),
    ]  # fmt: skip


def _plugged(commands: dict[int, Opcode]) -> list[Case]:
    def case(code: int, *texts: str, name: str = "", wait_s: float = 0.4) -> Case:
        command = commands[code]
        words = f"{code:02X}h {name or command.name}, with the test plug"
        says = (*(bytes.fromhex(text) for text in texts), b"\x88", b"\x8c", b"\x94", b"\x97")
        return Case(words, command.chapter, says, moves=True, writes=True, wait_s=wait_s, plug=True)

    slow, move = "31 00 00 00 00 00 C8 00 00 27 10", "33 00 00 01 90"
    sequence = ("D9 0F", "29 00 00 07 D0", "01 07", "D8")
    found = [
        case(0x0B, "0C 01", "94", "0B 01", "94", "0C 02", "8A", "0B 02", "8A"),
        case(0x0D, "0D 00", "94", "8A", "0D 02", "94", "8A", "0D 04", "94", "8A", "0D 06", "94", "8A"),
        case(0x2C, "0D 06", "D9 0F", "2C 02 00", "01 07", "D8", "41 0F", "0D 04", "0D 06", "79", "DA 0F"),
    ]
    for trigger, low in ((1, "0D 04"), (6, "0D 02")):
        number = f"{trigger:02X}"
        found += [
            case(0xAC, low, f"AC {number} 01", "0D 06", low, "0D 06", f"AC {number} 00", low, "0D 06",
                 name=f"interrupt on trigger {trigger}"),
            *(
                case(code, low, f"{code:02X} {number} {on}", slow, move, "0D 06", "8C", low, "0D 06", "78",
                     name=f"{commands[code].name} {trigger}, {on}")
                for code in (0x74, 0x7C, 0x77) for on in ("01 01", "01 00", "00 01")[: 3 if trigger == 1 else 1]
            ),
            *(
                case(code, low, *sequence, f"{code:02X} {number} {on}", "41 0F", "0D 06", "48", "88", "79", "DA 0F",
                     f"{code:02X} {number} 00 00", name=f"{commands[code].name} {trigger}, {on}")
                for code in (0x75, 0x76, 0x7D, 0x7E) for on in ("01 01", "01 00")[: 2 if trigger == 1 else 1]
            ),
            case(0x7F, "53 03 10 00 00 00 00 00 64", low, f"7F {number} 01 01", "E3 01 00 05" + " 00" * 12, "E2",
                 "0D 06", "E2", f"7F {number} 00 00", "78", "50", name=f"{commands[0x7F].name} {trigger}"),
        ]  # fmt: skip
    return [
        *found,
        *(
            case(code, "0D 00", f"{code:02X} 01", "31 00 00 00 00 00 C8 00 00 27 10", "33 FF FF FE 70", "0D 02", "89",
                 "88", "0D 00", "33 FF FF FF FB", f"{code:02X} 00", name=f"{commands[code].name}, and its time")
            for code in (0xAA, 0xAB)
        ),
        case(0x0D, "0D 00", "31 00 00 00 00 03 E8 00 00 27 10", name="outputs low"),
    ]  # fmt: skip


def _bare(commands: dict[int, Opcode]) -> list[Case]:
    def case(code: int, *texts: str, plug: bool = False, wait_s: float = 0.4) -> Case:
        command = commands[code]
        says = tuple(bytes.fromhex(text) for text in (*texts, "88", "8C", "97"))
        words = f"{code:02X}h {command.name}, without a machine"
        return Case(words, command.chapter, says, moves=True, writes=True, wait_s=wait_s, bare=True, plug=plug)

    return [
        case(0x10, "30", "95", "11", "95", "33 00 00 00 05", "83", "10", "95", "33 00 00 00 05", "83"),
        *(
            case(code, "0D 00", "31 00 00 00 00 00 C8 00 00 27 10", "A0 01", text, "8C", "78", "8C")
            for code, text in {0x35: "35 00 00 00 28", 0x36: "36 00 00 00 28"}.items()
            if code in commands
        ),
        case(0x12, "30", "94", "12 01", "94", "33 00 00 00 05", "83", "12 00", "94", "33 00 00 00 05", "83", plug=True),
        case(0x13, "13 01", "0D 04", "94", "0D 06", "94", "13 00", "0D 04", "94", "0D 06", "94", plug=True),
        case(0x14, "0D 00", "14 00", "33 00 00 00 05", "94", "14 01", "33 00 00 00 05", "94", "14 00", plug=True),
        case(0x39, "0D 04", "38 01 00 32 00", "31 00 00 00 00 01 F4 00 00 27 10", "A4 01", "39 00", "8C", "0D 00",
             "0D 04", "78", "8A", "0D 00", "A4 00", plug=True, wait_s=0.6),
    ]  # fmt: skip


def equip(controller: Controller, facts: Mapping[str, str]) -> None:
    """Connect outputs of the twin to its inputs, if a test plug does so at the real board."""
    if facts.get("plug") == str(True):
        connect(controller, "output1", "trigger1", "trigger2", "shutdown_in", "ccw_limit")
        connect(controller, "output2", "trigger6", "home")
        connect(controller, "shutdown", "trigger3")
        connect(controller, "direction", "trigger4")


def examine(end: End, _: Product) -> Condition:
    """Read mode, part number and state.  Raises LinkError if the board is silent or the motor moves."""
    answers = {}
    for code in (MODE, MOVING, PART):
        answers[code] = end.ask_again(bytes((code,)), re.escape(bytes((code,))) + b".{15}")
        if not answers[code]:
            raise LinkError(
                f"the board does not answer request {code:02X}h: "
                "a sequence definition may still be open; end the definition with command D8h, or reset the board"
            )
        if not answers[code].startswith(bytes((code,))):
            raise LinkError(
                f"the board answers request {code:02X}h with {answers[code].hex(' ')}: expected {code:02x} and 15 more "
                "bytes; check --model and the data lines of the bus"
            )
    if answers[MOVING][1]:
        raise LinkError("the motor is moving: stop the motor, then run axistwin probe again")
    taken = end.ask(bytes((MOVE_PARAMETERS, MOVE)), patience_s=LATE_S).data
    reason = ""
    if answers[MODE][1] != INDEXER:
        reason = "the board is in a streaming mode: send 50h"
    elif taken:
        reason = f"move {MOVE} is defined: delete the move"
    part = answers[PART][1:].rstrip(b"\0").decode("latin-1")
    return Condition({"part number": part}, no_writes=reason, no_motion=reason)


def answer_form(_: bytes, answer: bytes) -> bytes:
    """Return the opcodes of all messages in an answer, without the values.

    A status byte becomes `.`, and a message that is not whole is left as it is.
    """
    if len(answer) % MESSAGE:
        return b"." if len(answer) == 1 else answer
    return answer[::MESSAGE]


def candidates(answers: Mapping[str, bytes]) -> dict[str, list[object]]:
    """Suggest a value for the twin's option `part_number`: the part number that the board reports."""
    for name, answer in answers.items():
        if name.startswith("FDh") and name.endswith("number") and answer:
            return {"part_number": [answer[1:].rstrip(b"\0").decode("latin-1")]}
    return {}


DIALECT = Dialect(
    cases, examine, lambda facts: b"\x01\x07", answer_form, equip=equip, definitions=(MOVE_PARAMETERS, LISTS),
    candidates=candidates,
)  # fmt: skip
