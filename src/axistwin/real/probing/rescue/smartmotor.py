"""Reading of a SmartMotor: program, gains, settings, variables and arrays, by reports and PRINT."""

from functools import partial
from itertools import count
from string import ascii_lowercase

from axistwin.core.errors import LinkError
from axistwin.real.hosts.exchange import Exchange
from axistwin.real.probing.rescue.contents import Contents, Reader, Restoring

REPORT = b"Ra\r"  # Report of a variable: an error in the language of all other controllers.
FIRST = b"\x80" + REPORT  # First request: 80h addresses all motors and discards an incomplete command of another host.
SHORT_S = 0.1  # Silence after which no further motor answers.
ACKNOWLEDGE, END_OF_PROGRAM = b"\x06", b"\xff"
BLOCK = 8
STATE = ("RMODE", "RP", "RPE", "RV", "RW", "RCTR", "RU", *(f"RU{pin}A" for pin in "ABCDEFG"))
"""Reports that depend on the machine or on earlier motion."""
FACTS = ("RSP", "RCKS")
GAINS = ("KP", "KI", "KD", "KL", "KS", "KV", "KA", "KG")
SETTINGS = (
    "A", "V", "P", "D", "T", "E", "AMPS", "TH", "THD", "MFMUL", "MFDIV", "BASE", "SIZE", "SLN", "SLP", "F", "EPTR",
)  # fmt: skip
VARIABLES = tuple(letter * times for times in (1, 2, 3) for letter in ascii_lowercase)
ARRAY = 51
OVERLAID = (*VARIABLES[26:52], *VARIABLES[52:77])  # Variables in the memory of al[0] to al[50].
MISSING = (
    "data EEPROM (VST): reading it by VLD overwrites variables; a program that reads it needs the original values",
    "SLE or SLD, mode of the next G, brake commands, PIDn, OCHN, pin directions: no report; they may be in the program",
)


def read(exchange: Exchange) -> Contents:
    """Read program, settings and variables.  Raises LinkError if the motor is silent or moves."""
    _first(exchange)
    if exchange.needed(b"RBt\r", "the line format, e.g. --line '9600 8N1'") == "1":
        raise LinkError("the motor is moving: stop the motor, then run axistwin rescue again")
    found = Contents(depends={*STATE, "ADDR"}, missing=list(MISSING))
    before = exchange.line(b"RBs\r")
    for name in (*FACTS, *STATE):
        found.values[name] = exchange.line(name.encode() + b"\r")
    for name in GAINS:
        found.values[name] = exchange.line(f"R{name}\r".encode())
    for name in (*SETTINGS, "ADDR"):
        found.values[name] = exchange.line(f"PRINT({name},#13)\r".encode())
    for name in VARIABLES:
        found.values[name] = exchange.line(f"R{name}\r".encode())
    for index in range(ARRAY):
        found.values[f"al[{index}]"] = exchange.line(f"Ral[{index}]\r".encode())
    found.program = _upload(exchange, found)
    if before == "0" and exchange.line(b"RBs\r") == "1":
        # The motor did not know a request and set the flag Bs (syntax error), so clear Bs by the command Zs.
        exchange.end.send(b"Zs\r")
    silent = [name for name, value in found.values.items() if not value]
    if silent:
        found.missing.append(f"no answer to {', '.join(silent)}")
        found.depends.update(silent)
    return found


def reported(said: bytes, answer: bytes) -> bool:
    """True if an answer, perhaps with an echo before it, contains only numbers, each with a CR."""
    lines = answer.removeprefix(said).split(b"\r")
    return len(lines) > 1 and not lines.pop() and all(line.removeprefix(b"-").isdigit() for line in lines)


def _first(exchange: Exchange) -> None:
    """Test the connection to the motor.  Raises LinkError if several motors answer.

    The first request addresses all motors.  `exchange.echo` is set to True if the motor echoes.
    """
    answer = exchange.ask(FIRST, complete=partial(reported, FIRST))
    exchange.echo = answer.startswith(FIRST)
    answer += exchange.ask(REPORT, complete=lambda answer: False, patience_s=SHORT_S)
    # More than two answers to two requests mean that several motors are connected.
    if answer.removeprefix(FIRST).count(b"\r") > 2:
        raise LinkError("several motors answer: connect one motor at a time")
    exchange.sign_of_life = REPORT


def _upload(exchange: Exchange, found: Contents) -> str:
    """Read the program's source, "" if it is locked.  Raises LinkError if it ends too early."""
    text = b""
    for number in count():
        block = exchange.ask(ACKNOWLEDGE if number else b"UPLOAD\r", complete=_block)
        text += block.removesuffix(END_OF_PROGRAM)
        if block.endswith(END_OF_PROGRAM):
            return text.decode("latin-1")
        if number == 0 and not block:
            exchange.check_alive()
            found.missing.append("program: UPLOAD is not answered; the program is locked by LOCKP")
            return ""
        if len(block) < BLOCK:
            raise LinkError(
                f"the upload of the program stopped after {len(text)} characters: "
                "check the serial cable, then run axistwin rescue again"
            )
    raise AssertionError


def _block(answer: bytes) -> bool:
    return len(answer) >= BLOCK or answer.endswith(END_OF_PROGRAM)


def restore(contents: Contents, new: Contents) -> Restoring:
    found = Restoring()
    values = contents.values
    if contents.program:
        found.controller["program"] = "program.sms"
        found.files["program.sms"] = contents.program
    separate = any(values[name] != values[f"al[{n}]"] for n, name in enumerate(OVERLAID))
    if separate:
        found.controller["options"] = {"array_overlay": False}
    names = (*GAINS, *SETTINGS, *VARIABLES, *(f"al[{n}]" for n in range(ARRAY) if separate))
    changed = {name: int(values[name]) for name in names if values[name] not in ("", new.values[name])}
    if values["RP"] not in ("", "0"):
        changed["O"] = int(values["RP"])
    if "D" in changed:
        # The assignment of D selects relative moves, so write P last to select absolute moves.
        changed["P"] = changed.pop("P", int(values["P"] or 0))
    if changed:
        found.controller["variables"] = changed
    pins = int(values["RU"] or new.values["RU"])
    found.actions = [f"{pin} low" for bit, pin in enumerate("ABCDEFG") if not pins >> bit & 1]
    return found


READER = Reader(read, restore)
