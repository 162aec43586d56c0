"""Reports, and settings that are written, read and restored; expressions and wrong commands."""

import re
from collections.abc import Mapping

from axistwin.controllers.smartmotor.language.forms import Accept, Form, Instruction
from axistwin.real.probing.cases import Case, around
from axistwin.real.probing.smartmotor.still import CR, case

REPORTERS = re.compile(r"R([A-Z].*|[a-z].*)|Q")
CHANGING = ("RETURN", "RETURNF", "RETURNI", "RUN", "RI", "RS2", "RS4")
"""Commands with the letter R that are left out: they are not reports, or they clear flags."""
BUFFERED = ("A=", "V=", "P=", "KP=", "KI=", "KD=", "KL=", "KS=", "KV=", "KA=", "KG=")
"""Settings that take effect only at the next G or F."""
VARIABLES = ("a", "h", "z", "aa", "zz", "zzz")
ARRAYS = ("ab[0]", "ab[203]", "aw[101]", "al[50]")
EXPRESSIONS = ("1+2", "7-9", "-3*4", "7/2", "-7/2", "5&3", "5|3", "1<2", "2<=1", "3==3", "3!=3", "2147483647+1", "1/0")
REMOVES = "476"  # Firmware without the commands of section 1.3, which could change limits or modes of an older one.
DYNAMIC = ("RCLK", "RTEMP")  # Reports whose values change without a command.


def readings(commands: Mapping[str, Instruction], firmware: str) -> list[Case]:
    return [*_reports(commands), *_settings(commands), *_variables(commands), *_wrong(commands, firmware)]


def _reports(commands: Mapping[str, Instruction]) -> list[Case]:
    return [
        Case(f"{code}: {command.name}", command.chapter, (code.encode() + CR,), depends=True, form=code in DYNAMIC)
        for code, command in commands.items()
        if REPORTERS.fullmatch(code) and command.form is Form.BARE and code not in (*CHANGING, "Q")
        if Accept.HOST in command.accepted
    ]


def _settings(commands: Mapping[str, Instruction]) -> list[Case]:
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
            # The test case saves the tested setting in the motor's variable zzz, and restores this setting at the end.
            # PRINT(V) reports the setting V, the commanded velocity; the command RV reports the actual velocity.
            shown = f"PRINT({code[:-1]},#13)"
            # After a wrong value, the setting keeps the value 8, whatever it was before.
            before = f"zzz={code[:-1]} {code}8 Zd Zs"
            says = (before, sent, shown, report or shown, "RBd", "RBs", f"{code}zzz", "Zd Zs")
            found.append(case(f"{sent}: {command.name}, {words}", command.chapter, *says))
    return found


def _variables(commands: Mapping[str, Instruction]) -> list[Case]:
    section, arrays = commands["a…zzz="].chapter, commands["ab[]="].chapter
    found = [
        case(f"{name}={value}", section, f"{name}={value}", f"R{name}")
        for name in VARIABLES
        for value in (0, -5, 0x7FFF_FFFF)
    ]
    found += [
        case(f"{name}={value}", arrays, f"{name}={value}", f"R{name}", f"{name}=0", "RBu")
        for name in ARRAYS
        for value in (127, -128, 70_000)
    ]
    found += [case(f"a={text}", section, f"a={text}", "Ra", "RBd", "Zd") for text in EXPRESSIONS]
    printed = ('"text"', "#65", '"a=",a,#13', "1+2", '"a","b"')
    return [*found, *(case(f"PRINT({text})", commands["PRINT()"].chapter, f"PRINT({text})") for text in printed)]


def _wrong(commands: Mapping[str, Instruction], firmware: str) -> list[Case]:
    removed = [command for command in commands.values() if command.accepted is Accept.REMOVED and firmware == REMOVES]
    words = [(str(command.code).replace("=", "=1"), command.chapter) for command in removed]
    words += [
        (text, commands["Zs"].chapter) for text in ("RXX", "a==1", "b=", "PRINT(", "WAIT=1", "Rab[204]", "?", "Ga")
    ]
    return [case(f"{text}, an error", section, "Zs Zu", text, "RBs", "RBu", "Zs Zu", "RBs") for text, section in words]
