"""Cases for the IF1 and IF2.

A message without `$` only stores parameters, so settings can be tested without motion.
"""

import re
from collections.abc import Mapping
from dataclasses import replace

from axistwin.bench import Controller, line_format, product
from axistwin.controllers.digiplan.language import Accept, Instruction
from axistwin.controllers.product import Product
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import LATE_S, TRIES, End
from axistwin.real.probing.cases import Case, Condition, Dialect, around, connect

SPOIL = b"~"  # A character that is no command: a message with this character only sets the data fault bit.
FORMAT = b"U61\r"  # Data format message for an IF1 that waits for one.
TERMINATORS = {"\r": "U", "\n": "V"}  # First letter of the data format message by the terminator of messages.
FRAMES = {"data": 3, "0": 5, "1": 7}  # First digit of the data format message for one stop bit, by bit 8.
SILENT, ECHOING = {"N": 1, "O": 3, "E": 4}, {"N": 2, "O": 5, "E": 6}  # Second digit by parity.
HIGHEST = {b"K": 255, b"I": 255, b"F": 63, b"O": 63, b"N": 0xFFFF_FFFF}  # Largest answer to each request with a number.
LETTER, NUMBER = rb"[CEF\[\xc3\xc5\xc6\xdb].{1,2}", rb"[0-9\xb0-\xb9]+[\r\x8d]\n?"  # Forms of answers, also with bit 8.
SEVEN_BITS = bytes(code & 0x7F for code in range(256))
SETTINGS = "<>@^D"
LEGAL = {"<": 4, ">": 1, "@": 400, "^": 4, "D": 0}  # Legal values of the settings; the cases end with these values.
UNKNOWN = "!\"&'.;?\\_`abcdefghijklmnopqrstuvwxyz{|}"
IN_MOTION = 1
PLUGGED = "125"  # Outputs that the test plug connects to the inputs 1, 2 and 3.
RECALCULATION_S = 1.2  # Longest calculation of a new ramp in seconds, during which answers are delayed.
RAMP_S = 0.06
HAND_OVER_S = 3.0  # Longest duration of the steps before a hand-over.


def cases(product: Product, facts: Mapping[str, str]) -> list[Case]:
    end = facts.get("terminator", "\r").encode()
    commands = {command.code: command for command in product.commands if isinstance(command, Instruction)}
    return [
        *_requests(commands, end, _known(facts)), *_settings(commands, end), *_wrong(commands, end),
        *_moves(commands, end), *_plugged(commands, end), _ramp(commands, end),
    ]  # fmt: skip


def _known(facts: Mapping[str, str]) -> str:
    """Return the requests whose answers are known: an interface that is clear has no fault and does not move.

    After a power-up, it has made no step and started no step of a sequence.
    """
    clear = "EFKQ" if facts.get("busy status") == "C" else ""
    return clear + ("NO" if "initialised" in facts else "")


def _requests(commands: dict[str | int, Instruction], end: bytes, known: str) -> list[Case]:
    found = []
    for code, command in commands.items():
        if Accept.REQUEST in command.accepted:
            asked, depends = str(code).encode(), str(code) not in known
            found += [
                Case(f"{code}: {command.name}", command.chapter, (asked + end,), depends=depends),
                Case(f"{code} with spaces", command.chapter, (b" " + asked + b" " + end,), depends=depends),
                _error(f"{code} twice in a message", command.chapter, asked * 2 + end, b"F" + end),
                _error(f"{code} with a number", command.chapter, asked + b"1" + end, b"F" + end),
                Case(f"{code} after an empty message", command.chapter, (end + asked + end,), depends=depends),
            ]
    return found


def _error(name: str, section: str, *says: bytes, timed: bool = True) -> Case:
    """Return a test case with a data fault, which a locked interface does not set."""
    return Case(name, section, says, writes=True, timed=timed)


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
    found = [_error(f"unknown character {code!r}", section, code.encode() + end, b"F" + end) for code in UNKNOWN]
    says = tuple(text + end for text in (SPOIL, b"E", b"K", b"F", b"E", b"K"))
    found.append(_error("a data fault in the busy status and in the motion status", section, *says))
    texts = {
        "a number alone": "12", "a lone sign": "+", "a lone comma": ",", "a lone divider": ":",
        "a repeat outside a sequence": "=3,1",
        "a legal setting with an unknown character": "@400~", "two settings with an error": "@400 <0",
        "an input number of 4": "H4", "an output number of 6": "S6", "an abort outside a sequence": "A",
        "U during operation": "U61", "V during operation": "V61",
    }  # fmt: skip
    found += [
        _error(words, section, text.encode() + end, b"F" + end, b"F" + end, timed=False)
        for words, text in texts.items()
    ]
    for axis in "XYZ":
        for move in (f"{axis}+1", f"{axis}-100", f"{axis}16777215", f"{axis}+99999999"):
            name, chapter = f"{move} without $", commands[axis].chapter
            said, ask = move.encode() + end, b"N" + end
            found += [
                Case(name, chapter, (said, b"F" + end, b"E" + end), writes=True, timed=False),
                Case(f"{name}, and N", chapter, (ask, said, ask), writes=True, depends=True, timed=False),
            ]
    locking = tuple(text + end for text in (b"[", b"E", b"F", b"@0", b"F", b"]", b"E", b"F"))
    return [*found, Case("locked and unlocked", commands["["].chapter, locking, writes=True, timed=False)]


def _moves(commands: dict[str | int, Instruction], end: bytes) -> list[Case]:
    asks = (b"N", b"K", b"E", b"F", b"O")

    def case(name: str, code: str, *texts: bytes, wait_s: float = 1.5) -> Case:
        says = tuple(text + end for text in (*texts, *asks))
        return Case(
            name, commands[code].chapter, says, moves=True, writes=True, wait_s=wait_s if texts else 0, timed=False
        )

    # From here on, the answers to N and O are those after this sequence.
    found = [case("ramp settings", "<", b"< 4 > 1 @ 400 ^ 4", b":X+1:X-1:$")]
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
    """Return cases for the durations of steps; each sequence sends `%` at the end of its steps."""
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
    """Return a case that measures the ramp's calculation, after which the interface answers `F`."""
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
        case("R", b"S125$", b"I", b"R125$", b"I"), case("P", b":P2,99:$", b"I", b" ", b"I"),
        case("L", b"S1$", b":L1:X+10:$", b"E", b"#", b"E", b"R1$", b":L1:X-10:$", b"N"),
        case("H", b"R1$", b":H1:X+10:$", b"E", b"#", b"E", b"S1$", b":H1:X-10:$", b"N", b"R1$"),
    ]  # fmt: skip


def equip(controller: Controller, facts: Mapping[str, str]) -> None:
    """Connect outputs 1, 2 and 5 to inputs 1, 2 and 3, if a test plug does so at the real interface."""
    if facts.get("plug") == str(True):
        for number, output in zip("123", PLUGGED, strict=True):
            connect(controller, f"output{output}", f"input{number}")


def examine(end: End, made: Product) -> Condition:
    """Return the state of an IF1 or IF2 interface, and its data format.

    The fault flags of the interface are cleared.  An IF1 that waits for its data format is initialised.  An IF2 is not
    initialised, because the IF2 could start a stored sequence.
    """
    heard = b""
    for _ in range(TRIES):
        for terminator in TERMINATORS:
            code = terminator.encode()
            spoilt = end.ask(SPOIL + code).data
            end.echo = spoilt.translate(SEVEN_BITS).startswith(SPOIL)
            facts = {"terminator": terminator, "echo": str(end.echo)}
            answer = end.ask(b"E" + code, 2, patience_s=LATE_S).data
            if re.fullmatch(rb"[CEF\[]\r\n?", _text(b"E" + code, answer, facts)):
                facts["bit 8"] = "1" if answer[-1] & 0x80 else _eighth_bit(end, facts)
                return _condition(end, facts)
            heard = heard or spoilt + answer
        answer = end.ask(b"(", 2, patience_s=LATE_S).data
        if answer == b"U\r" and made.model == "if2":
            raise LinkError(
                "the IF2 has no data format yet: send the data format, e.g. U61, and run axistwin probe again "
                "(caution: U61 can start a stored sequence, so motors can move)"
            )
        if answer == b"U\r":
            return _initialised(end)
        heard = heard or answer
        end.settle()
        if not end.received:
            break
    check = "check --model and the line format, e.g. --line '9600 8N2', or switch the interface off and on"
    if heard:
        raise LinkError(f"the interface answers request E with {heard!r}: expected C, E, F or [ and CR; {check}")
    raise LinkError(f"the interface does not answer request E: {check}")


def _text(said: bytes, answer: bytes, facts: Mapping[str, str]) -> bytes:
    """Return an answer without the echo of the request and without bit 8."""
    text = answer.translate(SEVEN_BITS)
    return text.removeprefix(said) if facts["echo"] == str(True) else text


def _eighth_bit(end: End, facts: Mapping[str, str]) -> str:
    """Return what bit 8 of a character is: the quick status during a data fault is 80h, or 0 if bit 8 is always 0."""
    code = facts["terminator"].encode()
    end.ask(SPOIL + code)
    answer = end.ask(b"Q" + code, 1, patience_s=LATE_S).data
    end.ask_again(b"F" + code, NUMBER)
    return "data" if answer and answer[-1] & 0x80 else "0"


def _initialised(end: End) -> Condition:
    end.ask(FORMAT, wait_s=1.5)
    if not end.ask_again(b"E\r", LETTER):
        raise LinkError(
            "the interface does not answer after axistwin probe has sent U61 (data format 8N2): "
            "expected 8N2 in --line, e.g. --line '9600 8N2'"
        )
    condition = _condition(end, {"terminator": "\r", "echo": str(False), "bit 8": "0"})
    condition.facts["initialised"] = "by this program, with U61"
    return condition


def initialise(end: End, facts: Mapping[str, str]) -> None:
    """Give a new twin the real interface's data format: `(` sets the baud rate, then e.g. `U61` the format."""
    usual = product("if1").line
    assert usual is not None
    line, _ = line_format(facts.get("line") or None, usual)
    terminator = facts.get("terminator", "\r")
    frame = 1 if line.bytesize == 7 else FRAMES[facts.get("bit 8", "0")]
    parities = ECHOING if facts.get("echo") == str(True) else SILENT
    text = f"{TERMINATORS[terminator]}{frame + (line.stopbits == 2)}{parities[line.parity]}"
    end.set_line(replace(line, bytesize=8, parity="N", stopbits=2))
    end.ask(b"(", 2)
    end.ask(text.encode() + terminator.encode(), wait_s=1.5)
    end.set_line(line)


def _condition(end: End, facts: dict[str, str]) -> Condition:
    def asked(request: bytes) -> str:
        said = request + facts["terminator"].encode()
        answer = end.ask_again(said, LETTER if request == b"E" else NUMBER)
        return _text(said, answer, facts).strip().decode("latin-1")

    for request in (b"F", b"K", b"F"):
        asked(request)
    busy, motion, inputs = map(asked, (b"E", b"K", b"I"))
    facts |= {"busy status": busy, "inputs": inputs}
    if not motion.isdigit():
        raise LinkError(f"the answer to request K is {motion!r}, not a number: check --model and --line")
    if int(motion) & IN_MOTION:
        raise LinkError("the motor is moving: stop the motor, then run axistwin probe again")
    reasons = {"[": "the interface is locked: unlock it", "E": "a sequence is running or waiting: end it",
               "F": "a fault is active: close the limits and the emergency stop"}  # fmt: skip
    reason = reasons.get(busy, "")
    return Condition(facts, no_writes=reason, no_motion=reason)


def answer_form(said: bytes, answer: bytes) -> bytes:
    """Return an answer with `0` instead of a number and `C` instead of a letter of the busy status.

    An answer that the request cannot have, e.g. a number with leading zeros, is left as it is.
    """
    request = said.strip()
    text = answer.translate(SEVEN_BITS)
    echo = said if text.startswith(said) and len(text) > len(said) else b""
    text = text.removeprefix(echo)
    number = re.fullmatch(rb"(0|[1-9]\d*)(\r\n?)", text)
    if request in HIGHEST and number and int(number[1]) <= HIGHEST[request]:
        return echo + b"0" + number[2]
    if request == b"Q" and len(text) == 1:
        return echo + b"."
    return echo + re.sub(rb"^[CEF\[](?=\r\n?$)", b"C", text) if request == b"E" else answer


def first(facts: Mapping[str, str]) -> bytes:
    return b"E" + facts.get("terminator", "\r").encode()


DIALECT = Dialect(cases, examine, first, answer_form, equip=equip, initialise=initialise, patience_s=RECALCULATION_S)
