"""Cases for the SmartMotor: reports, settings, communications, programs, the data EEPROM, and motion."""

import re
from collections.abc import Mapping

from axistwin.bench import Controller
from axistwin.controllers.product import Product
from axistwin.controllers.smartmotor.language.forms import Instruction
from axistwin.errors import LinkError
from axistwin.probing.cases import Case, Condition, Dialect
from axistwin.probing.ends import End
from axistwin.probing.smartmotor.memory import CONTENTS, locking, restore, save, stored
from axistwin.probing.smartmotor.moving import moves
from axistwin.probing.smartmotor.reading import readings
from axistwin.probing.smartmotor.still import CR, case
from axistwin.probing.smartmotor.talking import talk

SPOIL = b"\x80" + CR
"""Addresses all motors, and discards a command that another host has not ended."""
FAULTS = ("RBr", "RBl", "RBe", "RBh")
"""Flags that forbid motion and the loading of programs."""
LIMITS = ("RBp", "RBm")
CLOSED, OPEN = "closed", "open"
RI_AFTER = 3
"""Place of the answer to RI among the answers of the case with the index mark, after RI, RBi, RBi."""
STATEMENTS = 7
"""Number of statements whose duration a case reports in samples."""


def cases(product: Product, facts: Mapping[str, str]) -> list[Case]:
    """Return all test cases for a SmartMotor, in the order in which a probe performs them."""
    commands = {str(command.code): command for command in product.commands if isinstance(command, Instruction)}
    return [
        *readings(commands, facts.get("firmware", "476")),
        *talk(commands, facts.get("address", "0")),
        case("inputs instead of limits", commands["UCI"].chapter, "UCI UDI ZS RW", bare=True),
        *stored(commands, facts.get("line", "9600 8N1")),
        *locking(commands),
        *moves(commands),
    ]


def examine(end: End, _: Product) -> Condition:
    """Read the state of the motor, e.g. the firmware version and the checksum of the stored program.

    Raises LinkError if the motor does not answer or is moving.
    """
    end.ask(SPOIL)
    answer = end.ask(b"RSP" + CR, expected=4).data
    match = re.search(rb"(\d+)/(\d+)\r", answer)
    if match is None:
        raise LinkError(
            f"the motor does not answer RSP (received {answer!r}): check the line format, e.g. --line '9600 8N1', "
            "and the motor's address"
        )
    facts = {"firmware": match[2].decode(), "sample period": match[1].decode()}
    if end.ask(b"RBt" + CR, expected=2).data.strip() == b"1":
        raise LinkError("the motor is moving: stop the motor, then run axistwin probe again")
    facts["checksum"] = end.ask(b"RCKS" + CR, expected=16).data.strip().decode("latin-1")
    facts["mode"] = end.ask(b"RMODE" + CR, expected=2).data.strip().decode("latin-1")
    facts["address"] = end.ask(b"RADDR" + CR).data.strip().decode("latin-1")
    faulty, open_limits = (any(_set(end, flag) for flag in flags) for flags in (FAULTS, LIMITS))
    facts["limits"] = OPEN if open_limits else CLOSED
    reason = ""
    if facts["checksum"].removesuffix(" P") not in CONTENTS:
        reason = "a program is stored, which could use the variables: save it with `axistwin rescue`, then clear it"
    elif facts["mode"] not in "OBPRE":
        reason = f"the motor is in mode {facts['mode']}, in which settings could act at once: send OFF"
    machine = "a limit switch is open: close it" if open_limits else ""
    fault = "a fault has not been cleared, so programs cannot be loaded: send ZS" if faulty else ""
    return Condition(facts, no_writes=reason, no_motion=reason, no_memory=reason, machine=machine or fault)


def _set(end: End, flag: str) -> bool:
    return end.ask(flag.encode() + CR, expected=2).data.strip() == b"1"


def equip(controller: Controller, facts: Mapping[str, str]) -> None:
    """Close the virtual motor's limit switches if the real motor's limit switches are closed."""
    if facts.get("limits") == CLOSED:
        for pin in "CD":
            controller.pins[pin].drive(False)


def answer_form(answer: bytes) -> bytes:
    """Replace each number in an answer by `0`, so that a comparison ignores numbers.

    `0` also replaces each checksum, and `P` replaces the letter of a mode.
    """
    return re.sub(rb"\b[0-9A-F]{6}\b|-?\d+", b"0", re.sub(rb"^[A-Z]\r", b"P\r", answer))


def candidates(answers: Mapping[str, bytes]) -> dict[str, list[object]]:
    """Suggest values for the twin's options `index_at` and `statements_per_sample`.

    The values are calculated from the motor's answers.
    """
    found: dict[str, list[object]] = {}
    index = re.findall(rb"-?\d+", answers.get("the index", b""))
    if len(index) > RI_AFTER and int(index[RI_AFTER]) > 0:
        found["index_at"] = [int(index[RI_AFTER])]
    samples = re.match(rb"\d+", answers.get("the duration of a statement", b""))
    if samples and int(samples[0]):
        found["statements_per_sample"] = [max(1, round(STATEMENTS / int(samples[0])))]
    return found


DIALECT = Dialect(
    cases, examine, b"RSP\r", answer_form, equip=equip, save=save, restore=restore, candidates=candidates
)  # fmt: skip
