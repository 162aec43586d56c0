"""Cases for the SmartMotor: reports, settings, communications, programs, the data EEPROM, and motion."""

import re
from collections.abc import Mapping

from axistwin.bench import Controller
from axistwin.controllers.product import Product
from axistwin.controllers.smartmotor.language.forms import Instruction
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import End
from axistwin.real.probing.cases import Case, Condition, Dialect
from axistwin.real.probing.smartmotor.communications import talk
from axistwin.real.probing.smartmotor.memory import CONTENTS, locking, restore, save, stored
from axistwin.real.probing.smartmotor.moving import moves
from axistwin.real.probing.smartmotor.reading import readings
from axistwin.real.probing.smartmotor.still import CR, case

SPOIL = b"\x80" + CR  # Addresses all motors, and discards a command that another host has not ended.
FAULTS = ("RBr", "RBl", "RBe", "RBh")  # Flags that forbid motion and the loading of programs.
LIMITS = ("RBp", "RBm")
FLAG = re.compile(rb"R(B[a-z]|U[A-G])\r")  # Reports of a flag or of the level of a pin.
CLOSED, OPEN = "closed", "open"
RI_AFTER = 3  # Place of the answer to RI among the answers of the case with the index mark, after RI, RBi, RBi.
STATEMENTS = 7  # Number of statements whose duration a case reports in samples.


def cases(product: Product, facts: Mapping[str, str]) -> list[Case]:
    commands = {str(command.code): command for command in product.commands if isinstance(command, Instruction)}
    return [
        *readings(commands, facts.get("firmware", "476")), *talk(commands, facts.get("address", "0")),
        case("inputs instead of limits", commands["UCI"].chapter, "UCI UDI ZS RW", bare=True),
        *stored(commands, facts.get("line", "9600 8N1")), *locking(commands), *moves(commands),
    ]  # fmt: skip


def examine(end: End, _: Product) -> Condition:
    """Read version, checksum and state of the motor.  Raises LinkError if it is silent or moves."""
    end.ask(SPOIL)
    answer = end.ask_again(b"RSP" + CR, rb"\d+/\d+\r")
    match = re.search(rb"(\d+)/(\d+)\r$", answer)
    if match is None:
        check = "check --model and the line format, e.g. --line '9600 8N1', and the motor's address"
        if answer:
            raise LinkError(f"the motor answers RSP with {answer!r}: expected e.g. 24576/476 and CR; {check}")
        raise LinkError(f"the motor does not answer RSP: {check}")
    facts = {"firmware": match[2].decode(), "sample period": match[1].decode()}
    end.echo = answer.startswith(b"RSP")
    facts["echo"] = str(end.echo)
    if _report(end, "RBt") == "1":
        raise LinkError("the motor is moving: stop the motor, then run axistwin probe again")
    facts["checksum"] = _report(end, "RCKS", rb"\w{6} \w{6} \w\r")
    facts["mode"] = _report(end, "RMODE", rb"[A-Z]\r")
    facts["address"] = _report(end, "RADDR")
    faulty, open_limits = (any(_report(end, flag) == "1" for flag in flags) for flags in (FAULTS, LIMITS))
    facts["limits"] = OPEN if open_limits else CLOSED
    reason = ""
    if facts["checksum"].removesuffix(" P") not in CONTENTS:
        reason = "a program is stored, which could use the variables: save it with `axistwin rescue`, then clear it"
    elif facts["mode"] not in "OBPRE":
        reason = f"the motor is in mode {facts['mode']}, in which settings could act at once: send OFF"
    machine = "a limit switch is open: close it" if open_limits else ""
    fault = "a fault has not been cleared, so programs cannot be loaded: send ZS" if faulty else ""
    return Condition(facts, no_writes=reason, no_motion=reason, no_memory=reason, machine=machine or fault)


def _report(end: End, name: str, form: bytes = rb"\d+\r") -> str:
    """Return the answer to a report without an echo of its request."""
    said = name.encode() + CR
    return end.ask_again(said, form).removeprefix(said).strip().decode("latin-1")


def initialise(end: End, facts: Mapping[str, str]) -> None:
    if facts.get("echo") == str(True):
        end.ask(b"ECHO" + CR)


def equip(controller: Controller, facts: Mapping[str, str]) -> None:
    """Close the virtual motor's limit switches if the real motor's limit switches are closed."""
    if facts.get("limits") == CLOSED:
        for pin in "CD":
            controller.pins[pin].drive(False)


def answer_form(said: bytes, answer: bytes) -> bytes:
    """Return an answer with `0` instead of each number and checksum, and `P` instead of the letter of a mode.

    A number that the motor cannot report, e.g. one with leading zeros, is left as it is.
    """
    echo = said if answer.startswith(said) and len(answer) > len(said) else b""
    text = re.sub(rb"^[A-Z](?=\r)", b"P", answer.removeprefix(echo))
    if said == b"Q" + CR and re.fullmatch(rb"\xf9.{4}", text, re.DOTALL):
        return echo + b"Q"
    if FLAG.fullmatch(said):
        return echo + re.sub(rb"^[01](?=\r$)", b"0", text)
    return echo + re.sub(rb"\b[0-9A-F]{6}\b|(?<![\w-])(?:0|-?[1-9]\d{0,9})(?!\w)", b"0", text)


def candidates(answers: Mapping[str, bytes]) -> dict[str, list[object]]:
    """Suggest the twin's `index_at` and `statements_per_sample`, calculated from answers."""
    found: dict[str, list[object]] = {}
    index = re.findall(rb"-?\d+", answers.get("the index", b""))
    if len(index) > RI_AFTER and int(index[RI_AFTER]) > 0:
        found["index_at"] = [int(index[RI_AFTER])]
    samples = re.match(rb"\d+", answers.get("the duration of a statement", b""))
    if samples and int(samples[0]):
        found["statements_per_sample"] = [max(1, round(STATEMENTS / int(samples[0])))]
    return found


DIALECT = Dialect(
    cases, examine, lambda facts: b"RSP\r", answer_form, equip=equip, save=save, restore=restore,
    initialise=initialise, candidates=candidates
)  # fmt: skip
