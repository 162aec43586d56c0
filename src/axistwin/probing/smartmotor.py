"""Cases for the SmartMotor: reports, and settings that are written, read and restored."""

import re

from axistwin.controllers.product import Product
from axistwin.controllers.smartmotor.language.forms import Accept, Form, Instruction
from axistwin.errors import LinkError
from axistwin.probing.cases import Case, Condition, Dialect, around
from axistwin.probing.ends import End

CR = b"\r"
REPORTERS = re.compile(r"R([A-Z].*|[a-z].*)|Q")
CHANGING = ("RETURN", "RETURNF", "RETURNI", "RUN", "RI", "RS2", "RS4")
"""Commands with the letter R that are left out: they are not reports, or they clear flags."""
BUFFERED = ("A=", "V=", "P=", "KP=", "KI=", "KD=", "KL=", "KS=", "KV=", "KA=", "KG=")
"""Settings that take effect only at the next G or F."""
VARIABLES = ("a", "h", "z", "aa", "zz", "zzz")
ARRAYS = ("ab[0]", "ab[203]", "aw[101]", "al[50]")
EXPRESSIONS = ("1+2", "7-9", "-3*4", "7/2", "-7/2", "5&3", "5|3", "1<2", "2<=1", "3==3", "3!=3", "2147483647+1", "1/0")
ADDRESSED = 0x80
"""A byte above 80h selects one motor of a chain; 80h selects all."""
SPOIL = b"\x80" + CR
"""Addresses all motors, and discards a command that another host has not ended."""
DYNAMIC = ("RCLK", "RTEMP")
"""Reports whose values change without a command."""


def cases(product: Product, _: str) -> list[Case]:
    """Return the cases: reports, settings, expressions, wrong commands; then moves."""
    commands = {str(command.code): command for command in product.commands if isinstance(command, Instruction)}
    return [*_reports(commands), *_settings(commands), *_variables(commands), *_wrong(commands), *_moves(commands)]


def _reports(commands: dict[str, Instruction]) -> list[Case]:
    return [
        Case(f"{code}: {command.name}", command.chapter, (code.encode() + CR,), depends=True)
        for code, command in commands.items()
        if REPORTERS.fullmatch(code) and command.form is Form.BARE and code not in (*CHANGING, "Q", *DYNAMIC)
        if Accept.HOST in command.accepted
    ]


def _settings(commands: dict[str, Instruction]) -> list[Case]:
    found = []
    for code in BUFFERED:
        command = commands[code]
        (parameter,) = command.parameters
        report = f"R{code[:-1]}" if f"R{code[:-1]}" in commands and code != "P=" else ""
        ends = around(parameter.low, parameter.high) if code != "P=" else {"0": 0}
        for words, value in {**ends, "a value": 7, "an expression": 9}.items():
            if not -0x8000_0000 <= value <= 0x7FFF_FFFF:
                continue
            sent = f"{code}{'3*3' if words == 'an expression' else value}"
            # variable zzz saves the present value, which is restored afterwards
            shown = f"PRINT({code[:-1]},#13)"  # RV and RP report the motion, not the setting
            says = (f"zzz={code[:-1]}", sent, shown, report or shown, "RBd", "RBs", f"{code}zzz", "Zd Zs")
            found.append(_case(f"{sent}: {command.name}, {words}", command.chapter, *says))
    return found


def _variables(commands: dict[str, Instruction]) -> list[Case]:
    section, arrays = commands["a…zzz="].chapter, commands["ab[]="].chapter
    found = [
        _case(f"{name}={value}", section, f"{name}={value}", f"R{name}")
        for name in VARIABLES
        for value in (0, -5, 0x7FFF_FFFF)
    ]
    found += [
        _case(f"{name}={value}", arrays, f"{name}={value}", f"R{name}", f"{name}=0", "RBu")
        for name in ARRAYS
        for value in (127, -128, 70_000)
    ]
    found += [_case(f"a={text}", section, f"a={text}", "Ra", "RBd", "Zd") for text in EXPRESSIONS]
    printing = commands["PRINT()"].chapter
    found += [
        _case(f"PRINT({text})", printing, f"PRINT({text})")
        for text in ('"text"', "#65", '"a=",a,#13', "1+2", '"a","b"')
    ]
    return found


def _wrong(commands: dict[str, Instruction]) -> list[Case]:
    removed = [command for command in commands.values() if command.accepted is Accept.REMOVED]
    words = [(str(command.code).replace("=", "=1"), command.chapter) for command in removed]
    words += [
        (text, commands["Zs"].chapter) for text in ("RXX", "a==1", "b=", "PRINT(", "WAIT=1", "Rab[204]", "?", "Ga")
    ]
    return [_case(f"{text}, an error", section, "Zs Zu", text, "RBs", "RBu", "Zs Zu", "RBs") for text, section in words]


def _case(name: str, section: str, *lines: str, moves: bool = False, wait_s: float = 0.0) -> Case:
    return Case(name, section, tuple(line.encode() + CR for line in lines), moves=moves, writes=True, wait_s=wait_s)


def _moves(commands: dict[str, Instruction]) -> list[Case]:
    motion = commands["G"].chapter
    modes = commands["MP"].chapter
    asks = ("RBt", "RMODE", "RBe", "RW")

    def case(name: str, section: str, *lines: str, wait_s: float = 0.3) -> Case:
        return _case(name, section, *lines, *asks, moves=True, wait_s=wait_s)

    return [
        case("settings for the moves", motion, "ZS", "MP", "A=1000", "V=100000", "O=0", "RP", wait_s=0),
        case("an absolute move", motion, "P=200", "G", "RP", "RPW", "P=0", "G", "RP"),
        case("a relative move", motion, "D=100", "G", "RP", "D=-100", "G", "RP"),
        case("a jog and its end", modes, "MV", "V=20000", "G", "X", "MP"),
        case("a stop", motion, "MV", "V=-20000", "G", "S", "MP"),
        case("a new origin", motion, "O=1000", "RP", "O=0", "RP"),
        case("gains in use", commands["F"].chapter, "zzz=KP", "KP=50", "F", "RKP", "KP=zzz", "F", "RKP"),
        case("mode torque without torque", modes, "T=0", "MT", "RT", "OFF"),
        case("outputs", commands["RU"].chapter, "RUA", "UAO", "UA=1", "RUA", "UA=0", "RUA", "UAI"),
        case("soft limits", commands["SLE"].chapter, "SLN=-50", "SLP=50", "SLE", "SLD"),
        case("the filter's rate", commands["PIDn"].chapter, "PID2", "RSP", "PID1", "RSP"),
        case("the functions", commands["F="].chapter, "F=16", "F=0"),
        case("switched off", motion, "OFF", "RMODE"),
    ]


def examine(end: End, _: Product) -> Condition:
    """Read firmware, checksum and mode.  Raises LinkError if the motor does not answer or is moving."""
    end.ask(SPOIL)
    answer = end.ask(b"RSP" + CR, expected=4).data
    match = re.search(rb"(\d+)/(\d+)\r", answer)
    if match is None:
        raise LinkError(
            f"the motor does not answer RSP (received {answer!r}): check the line format, e.g. --line '9600 8N1', "
            "and the address"
        )
    facts = {"firmware": match[2].decode(), "sample period": match[1].decode()}
    if end.ask(b"RBt" + CR, expected=2).data.strip() == b"1":
        raise LinkError("the motor is moving: stop the motor, then start again")
    facts["checksum"] = end.ask(b"RCKS" + CR, expected=16).data.strip().decode("latin-1")
    facts["mode"] = end.ask(b"RMODE" + CR, expected=2).data.strip().decode("latin-1")
    reason = ""
    if facts["checksum"].split()[1:2] not in (["000000"], ["0000E1"]):
        reason = "a program is stored, which could use the variables: save it with `axistwin rescue`, then clear it"
    elif facts["mode"] not in "OBPRE":
        reason = f"the motor is in mode {facts['mode']}, in which settings could act at once: send OFF"
    return Condition(facts, no_writes=reason, no_motion=reason)


def answer_form(answer: bytes) -> bytes:
    """Return an answer with each number replaced by `0`, and each letter of a mode by `P`."""
    return re.sub(rb"-?\d+", b"0", re.sub(rb"^[A-Z]\r", b"P\r", answer))


DIALECT = Dialect(cases, examine, b"RSP\r", answer_form)
