"""Cases for the IF1 and IF2.

A message without `$` only stores parameters, so settings can be tested without motion.
"""

import re
from collections.abc import Mapping

from axistwin.bench import Controller
from axistwin.controllers.digiplan.language import Accept, Instruction
from axistwin.controllers.product import Product
from axistwin.errors import LinkError
from axistwin.probing.cases import Case, Condition, Dialect, around, connect
from axistwin.probing.ends import End

SPOIL = b"~"
"""A character that is no command: a message with this character only sets the data fault bit."""
FORMAT = b"U61\r"
"""Data format message of a new twin."""
SETTINGS = "<>@^D"
LEGAL = {"<": 4, ">": 1, "@": 400, "^": 4, "D": 0}
"""Legal values of the settings; the cases end with these values."""
UNKNOWN = "!\"&'.;?\\_`abcdefghijklmnopqrstuvwxyz{|}"
IN_MOTION = 1
PLUGGED = "125"
"""Outputs that the test plug connects to the inputs 1, 2 and 3."""
RECALCULATION_S = 1.2
"""Longest time for the calculation of a new ramp, in seconds; answers are delayed during this time."""
RAMP_S = 0.06
HAND_OVER_S = 3.0
"""Longest duration of the steps before a hand-over."""


def cases(product: Product, facts: Mapping[str, str]) -> list[Case]:
    """Return all test cases for an IF1 or IF2, in the order in which a probe performs them."""
    end = facts.get("terminator", "\r").encode()
    commands = {command.code: command for command in product.commands if isinstance(command, Instruction)}
    return [
        *_requests(commands, end),
        *_settings(commands, end),
        *_wrong(commands, end),
        *_moves(commands, end),
        *_plugged(commands, end),
        _ramp(commands, end),
    ]


def _requests(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    found = []
    for code, command in commands.items():
        if Accept.REQUEST in command.accepted:
            asked = str(code).encode()
            found += [
                Case(f"{code}: {command.name}", command.chapter, (asked + end,), depends=True),
                Case(f"{code} with spaces", command.chapter, (b" " + asked + b" " + end,), depends=True),
                Case(f"{code} twice in a message", command.chapter, (asked * 2 + end, b"F" + end)),
                Case(f"{code} with a number", command.chapter, (asked + b"1" + end, b"F" + end)),
                Case(f"{code} after an empty message", command.chapter, (end + asked + end,), depends=True),
            ]
    return found


def _settings(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    found = []
    for code in SETTINGS:
        command = commands[code]
        (parameter,) = command.parameters
        back = b"%s%d%s" % (code.encode(), LEGAL[code], end)
        values: dict[str, object] = {"legal": LEGAL[code], **around(parameter.low, parameter.high)}
        if code == "D":
            del values["highest"]  # Do not test command D255, which delays each character by 2.55 s.
        for words, value in values.items():
            sent = f"{code}{value}".encode() + end
            found.append(_setting(f"{code}{value}: {command.name}, {words}", command.chapter, sent, back, end))
        for words, text in {"no number": "", "a space": f" {LEGAL[code]}", "zeros": f"000{LEGAL[code]}"}.items():
            sent = f"{code}{text}".encode() + end
            found.append(_setting(f"{code}{text}: {command.name}, {words}", command.chapter, sent, back, end))
    return found


def _setting(name: str, section: str, sent: bytes, back: bytes, end: bytes) -> Case:
    return Case(name, section, (sent, b"F" + end, back, b"F" + end), writes=True, timed=False)


def _wrong(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    section = commands["F"].chapter
    found = [Case(f"unknown character {code!r}", section, (code.encode() + end, b"F" + end)) for code in UNKNOWN]
    texts = {
        "a number alone": "12", "a lone sign": "+", "a lone comma": ",", "a lone divider": ":",
        "a repeat outside a sequence": "=3,1",
        "a legal setting with an unknown character": "@400~", "two settings with an error": "@400 <0",
        "an input number of 4": "H4", "an output number of 6": "S6", "an abort outside a sequence": "A",
        "U during operation": "U61", "V during operation": "V61",
    }  # fmt: skip
    found += [
        Case(words, section, (text.encode() + end, b"F" + end, b"F" + end), writes=text[0] == "@", timed=False)
        for words, text in texts.items()
    ]
    asks = (b"F" + end, b"E" + end, b"N" + end)
    for axis in "XYZ":
        for move in (f"{axis}+1", f"{axis}-100", f"{axis}16777215", f"{axis}+99999999"):
            says = (move.encode() + end, *asks)
            name, chapter = f"{move} without $", commands[axis].chapter
            found.append(Case(name, chapter, says, writes=True, depends=True, timed=False))
    locking = tuple(text + end for text in (b"[", b"E", b"F", b"@0", b"F", b"]", b"E", b"F"))
    return [*found, Case("locked and unlocked", commands["["].chapter, locking, writes=True, timed=False)]


def _moves(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    asks = (b"N", b"K", b"E", b"F", b"O")

    def case(name: str, code: str, *texts: bytes, wait_s: float = 1.5) -> Case:
        says = tuple(text + end for text in (*texts, *asks))
        return Case(
            name, commands[code].chapter, says, moves=True, writes=True, wait_s=wait_s if texts else 0, timed=False
        )

    found = [case("ramp settings", "<", b"< 4 > 1 @ 400 ^ 4")]
    for axis in "XYZ":
        found += [
            case(f"{axis} by 50 steps and back", axis, f"{axis}+50 @400 $".encode(), b"N", f"{axis}-50$".encode()),
            case(f"{axis} by the distance of the last move", axis, f"{axis}+$".encode(), f"{axis}-$".encode()),
        ]
    return [
        *found,
        *_durations(commands, end),
        case("backlash", "B", b"B+5", b"X+20$", b"X-20$", b"B+0"),
        case("faster than the start/stop speed", "@", b"< 4 @ 1000 X+200$", b"X-200 @400$"),
        case("interpolation", "/", b"X+40/Y+20$", b"X-40/Y-20$"),
        Case("a move during a move", commands["$"].chapter, tuple(
            text + end for text in (b"X+200 @400 $", b"X-100$", b"E")), moves=True, wait_s=0.02, timed=False),
        case("the end of both moves", "$", b" "),
        case("back after both moves", "$", b"X-100$"),
        case("a sequence", ":", b":X+10:X-10:$", b"O"),
        case("a repeat", "=", b":X+5:=3,1:X-20:$", b"N", b"N"),
        Case(
            "a long repeat",
            commands["="].chapter,
            tuple(text + end for text in (b":X+1:=250,1:Y+1:$", b"E", b"#", b"E")),
            moves=True,
            writes=True,
            wait_s=0.3,
            timed=False,
        ),
        # The final position of this move is not repeatable, so this test case does not check the position.
        Case("a run and its end", commands["G"].chapter, tuple(
            text + end for text in (b"X+G$", b"K", b"#", b"K", b"E", b"F")), moves=True, writes=True, wait_s=0.5),
    ]  # fmt: skip


def _durations(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    """Return test cases for the durations of the steps of a sequence.

    Each sequence sends `%` when its steps have ended.
    """
    setting = {
        "<": (b"<8", b"<4"), ">": (b">4", b">1"), "^": (b"^20", b"^4"), "D": (b"D5", b"D0"), "Y": (b"^10", b"^4"),
        "Z": (b"^10", b"^4"),
    }  # fmt: skip
    steps = {
        "<": b"X+200@2000:X-200", ">": b"X+20@20:X-20", "^": b"X+200@2000:X-200", "@": b"X+50@123:X-50@400",
        "D": b"P0,5", "B": b"B+40:X-50B:X+50B:B+0", "=": b"X+5@100:=2,1:X-15", "P": b"P0,20", "H": b"H1:P0,5",
        "L": b"L1:P0,5",
        "A": b"X@100G:P0,20:L1A:X-20@400", "Z": b"X+40/Z+20@200:X-40/Z-20", "Y": b"X+40/Y+20@200:X-40/Y-20",
        "%": b"P0,5",
    }  # fmt: skip
    found = []
    for code, text in steps.items():
        before, after = setting.get(code, (b"E", b"E"))
        says = tuple(said + end for said in (before, b"F", b":" + text + b":%:$", b"F", b"%", b"#", b"O", b"N", after))
        name = f"{code}: {commands[code].name}, and the time of a hand-over"
        found.append(
            Case(name, commands[code].chapter, says, moves=True, writes=True, depends=code in "HLA", wait_s=HAND_OVER_S)
        )
    return found


def _ramp(commands: dict[str | int, Instruction], end: bytes) -> Case:
    """Return a test case that measures how much time the interface needs to calculate a ramp.

    The interface answers the request `F` only after the calculation.
    """
    says = (b"^7" + end, b"F" + end, b"^4" + end, b"F" + end)
    waits = ((0, RAMP_S), (2, RAMP_S))
    return Case("the time of a calculation", commands["^"].chapter, says, writes=True, waits=waits, bare=True)


def _plugged(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    """Return test cases in which a test plug connects outputs 1, 2 and 5 to inputs 1, 2 and 3."""

    def case(code: str, *texts: bytes) -> Case:
        says = tuple(text + end for text in (*texts, b"E", b"F"))
        name = f"{code}: {commands[code].name}, with the test plug"
        return Case(name, commands[code].chapter, says, moves=True, writes=True, wait_s=1.5, timed=False, plug=True,
                    waits=((0, 0.1),) if code == "P" else ())  # fmt: skip

    return [
        case("S", b"R125$", b"I", b"S1$", b"I", b"S25$", b"I", b"R2$", b"I", b"R15$", b"I"),
        case("R", b"S125$", b"I", b"R125$", b"I"),
        case("P", b":P2,99:$", b"I", b" ", b"I"),
        case("L", b"S1$", b":L1:X+10:$", b"E", b"#", b"E", b"R1$", b":L1:X-10:$", b"N"),
        case("H", b"R1$", b":H1:X+10:$", b"E", b"#", b"E", b"S1$", b":H1:X-10:$", b"N", b"R1$"),
    ]


def equip(controller: Controller, facts: Mapping[str, str]) -> None:
    """Connect outputs of the virtual interface to inputs of the same interface, like a test plug.

    Without a test plug at the real interface, the function does nothing.
    """
    if facts.get("plug") == str(True):
        for number, output in zip("123", PLUGGED, strict=True):
            connect(controller, f"output{output}", f"input{number}")


def examine(end: End, made: Product) -> Condition:
    """Return the state of an IF1 or IF2 interface, and its message terminator (CR or LF).

    The fault flags of the interface are cleared.  An IF1 that waits for its data format is initialised.  An IF2 is not
    initialised, because the IF2 could start a stored sequence.
    """
    for terminator in ("\r", "\n"):
        code = terminator.encode()
        end.ask(SPOIL + code)
        if re.fullmatch(rb"[CEF\[]\r\n?", end.ask(b"E" + code, 2).data):
            return _condition(end, terminator)
    answer = end.ask(b"(", 2).data
    if answer == b"U\r" and made.model == "if2":
        raise LinkError(
            "the IF2 has no data format yet: send the data format, e.g. U61, and run axistwin probe again "
            "(caution: U61 can start a stored sequence, so motors can move)"
        )
    if answer == b"U\r":
        return _initialised(end)
    raise LinkError(
        f"the interface does not answer request E (received {answer!r}): check the line format, "
        "e.g. --line '9600 8N2', or switch the interface off and on"
    )


def _initialised(end: End) -> Condition:
    end.ask(FORMAT, wait_s=1.5)
    if not end.ask(b"E\r", 2).data:
        raise LinkError(
            "the interface does not answer after axistwin probe has sent U61 (data format 8N2): "
            "expected 8N2 in --line, e.g. --line '9600 8N2'"
        )
    condition = _condition(end, "\r")
    condition.facts["initialised"] = "by this program, with U61"
    return condition


def initialise(end: End) -> None:
    """Initialise an IF1 or IF2: the character `(` sets the baud rate, and the command U61 sets the data format."""
    end.ask(b"(", 2)
    end.ask(FORMAT, wait_s=1.5)


def _condition(end: End, terminator: str) -> Condition:
    code = terminator.encode()
    for request in (b"F", b"K", b"F"):
        end.ask(request + code, 2)
    busy, motion, inputs = (end.ask(request + code, 2).data.strip() for request in (b"E", b"K", b"I"))
    facts = {"terminator": terminator, "busy status": busy.decode("latin-1"), "inputs": inputs.decode("latin-1")}
    if not motion.isdigit():
        raise LinkError(f"the answer to request K is {motion!r}, not a number: check --model and --line")
    if int(motion) & IN_MOTION:
        raise LinkError("the motor is moving: stop the motor, then run axistwin probe again")
    reasons = {b"[": "the interface is locked: unlock it", b"E": "a sequence is running or waiting: end it",
               b"F": "a fault is active: close the limits and the emergency stop"}  # fmt: skip
    reason = reasons.get(busy, "")
    return Condition(facts, no_writes=reason, no_motion=reason)


def answer_form(answer: bytes) -> bytes:
    """Replace each number in an answer by `0`, so that a comparison ignores numbers."""
    if len(answer) == 1:
        return b"."
    return re.sub(rb"\d+", b"0", re.sub(rb"[CEF\[](?=\r)", b"C", answer))


DIALECT = Dialect(
    cases, examine, b"E", answer_form, equip=equip, initialise=initialise, patience_s=RECALCULATION_S
)  # fmt: skip
