"""Cases of a SmartMotor: the whitelist of commands that move nothing, programs and memory, and restored contents.

Expected values are those of the 4.76 manual and of the guide to its base language, worked out by hand.
"""

import json
from functools import cache

import pytest

from axistwin import Bench
from axistwin.bench import product
from axistwin.controllers.smartmotor.nonvolatile import Nonvolatile
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Motion, Settings, Twin, Verdict, probe
from axistwin.real.probing.smartmotor import memory, moving, still

from ..command import run

MEMORY = Settings(memory=True, find_options=False)
STARTS = (
    "G", "S", "X", "MT", "MF1", "MF2", "MF4", "MS", "MC", "MP", "MV", "MD", "MTB", "OFF", "CI", "F", "F=2", "E=5",
    "O=5", "AMPS=0", "TH=0", "THD=0", "D=5", "PID2", "SLE", "UCI", "UCP", "UDM", "UG", "UAO", "UAI", "UA=1", "BRKRLS",
    "BRKENG",
    "BRKSRV", "BRKTRJ", "BRKC", "RS4", "OCHN(RS4,0,N,9600,1,8,C)", "PRINTA(1)", "ZS", "Zr", "Z", "RI", "RETURNI",
)  # fmt: skip
"""Commands that move something, switch something, or permit motion after a fault."""
STAYS = ("RP", "RW", "RUA", "Rab[3]", "RAINA1", "a=5", "KP=3", "P=100", "VST(a,2)", "GOSUB5", "WHILE a<3", "RXX", "Zs")


@cache
def twin():
    made = product("smartmotor")
    family = dialect(made)
    facts = {"line": "9600 8N1"}
    return Twin(made, family, family.cases(made, facts), None, {}, facts)


def answers(name):
    (found,) = (answers for case, answers in twin().answers.items() if case.name == name)
    return b"".join(answer.data for answer in found)


def motor(**options):
    """Return a motor with closed limit switches, and its host."""
    bench = Bench()
    made = bench.add("smartmotor", **options)
    for pin in "CD":
        made.pins[pin].drive(False)
    bench.run(2)
    return made, VirtualEnd(bench, made)


def load(end, program):
    for request in memory.loading(program):
        end.ask(request)


def report(end, *names):
    return [end.ask(f"R{name}\r".encode(), 2).data.decode().strip() for name in names]


def test_what_could_move_something_is_not_in_the_whitelist_and_reports_variables_and_program_flow_are():
    assert [text for text in (*STARTS, *STAYS) if still.still(text)] == [*STAYS]


def test_the_programs_without_motion_consist_of_whitelisted_statements_and_stop_after_power_up():
    for program in (memory.FLOW, memory.CHANNEL):
        lines = program.splitlines()
        assert all(map(still.still, lines)) and "RUN?" in lines[:2]
        assert all(line == "RUN?" or line.startswith("PRINT") for line in lines[: lines.index("RUN?") + 1])
    assert not all(map(still.still, moving.INTERRUPTS.splitlines()))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # b=1, then 1*10+2 in the inner and 12*10+3 in the outer subroutine
        ("a subroutine in a subroutine", b"123\r0\r"),
        # c=1: ELSE 100, c=2: IF 1, c=3: ELSEIF 10, c=4: ELSE 100 and BREAK
        ("WHILE, IF, BREAK", b"4\r211\r0\r"),
        ("SWITCH with 1", b"11\r"), ("SWITCH with 2", b"10\r"), ("SWITCH with 3", b"1100\r"),
        ("SWITCH with 9", b"1000\r"),
        ("GOTO", b"11\r0\r"), ("GOTO of a host", b"5\r0\r"),
        # STACK forgets the caller, so RETURN sets Bs and ends the program before h=2
        ("STACK", b"1\r1\r"),
        ("WAIT", b"w\rx\r0\r"), ("RUN and RUN?", b"boot\rrun\rboot\rrun\r0\r"),
        ("SILENT and TALK of a program", b"t\rp\r"), ("a pause until a character", b"y\r0\r"),
        # 16909060 is 01020304h
        ("the most significant byte first", b"1\r2\r3\r4\r"),
        # two longs advance EPTR by 8
        ("two variables", b"7908\r11\r-22\r7908\r0\r"),
        ("beyond a group", b"1\r7900\r1\r7900\r1\r"), ("beyond the memory", b"1\r7997\r0\r"),
        ("OCHN for data", b"2\r88\r89\r0\r"), ("too much data", b"16\r1\r1\r0\r"), ("BAUD", b"1\r0\r2\r0\r"),
        ("OCHN with parity", b"1\r0\r8\r0\r"), ("addresses", b"24576/476\r1\r1\r1\r1\r0\r"),
        ("an encoder's counts", b"0\r8\r4\r0\rB\r0\r128\r"), ("mode step with ratio", b"X\r10\r0\rB\r0\r128\r"),
    ],
)  # fmt: skip
def test_the_expected_answers_are_those_of_the_manual(name, expected):
    assert answers(name) == expected


def test_program_variables_and_eeprom_are_restored_and_nothing_moves():
    made, end = motor()
    load(end, "END\n")
    end.ask(b"ZS a=5 z=-7 al[2]=123456 EPTR=7900 VST(z,1) VST(al[2],1) EPTR=77\r")
    before = report(end, "CKS", "a", "z", "al[2]", "EPTR")
    assert before == ["000000 0000E1 P", "5", "-7", "123456", "77"]
    found = probe("smartmotor", end, MEMORY)
    assert found.not_restored == "" and not found.of(Verdict.DIFFERS)
    assert sum(result.case.stores for result in found.of(Verdict.SAME)) == 37
    assert report(end, "CKS", "a", "z", "al[2]", "EPTR") == before
    end.ask(b"EPTR=7900 VLD(b,2)\r")
    assert report(end, "b", "c") == ["-7", "123456"]
    assert made.axes["shaft"].position == 0 and [made.pins[pin].level for pin in "ABEFG"] == [True] * 5


def test_a_stored_program_is_neither_run_nor_overwritten():
    _, end = motor()
    load(end, 'PRINT("mine") END\n')
    found = probe("smartmotor", end, MEMORY, twin())
    skipped = [result for result in found.of(Verdict.INCONCLUSIVE) if result.case.stores]
    assert len(skipped) == 37
    assert all(result.reason.startswith("a program is stored") and not result.received for result in skipped)
    assert end.ask(b"RUN\r").data == b"mine"


def test_open_limit_switches_forbid_programs_and_motion():
    bench = Bench()
    end = VirtualEnd(bench, bench.add("smartmotor"))
    bench.run(2)
    found = probe("smartmotor", end, Settings(Motion.SMALL, memory=True, find_options=False), twin())
    reasons = {result.reason for result in found.results if result.case.stores or result.case.moves}
    assert reasons == {"a limit switch is open: close it"}
    assert report(end, "CKS") == ["000000 000000 P"]


def test_a_memory_that_cannot_be_restored_is_named(monkeypatch):
    _, end = motor()
    made = product("smartmotor")
    family = dialect(made)
    condition = family.examine(end, made)
    family.save(end, condition)
    load(end, memory.CHANNEL)
    monkeypatch.setattr(Nonvolatile, "save", lambda memory, store: setattr(memory, "broken", True))
    assert family.restore(end, condition) == (
        "RCKS reports 000000 000000 F instead of 000000 000000 P: switch the motor off and on, then load the program "
        "END"
    )


def test_the_report_names_what_has_not_been_restored():
    bench = Bench()
    end = VirtualEnd(bench, bench.add("1811"))
    bench.run(2)
    found = probe("1811", end)
    found.not_restored = "the program"
    assert json.loads(json.dumps(found.as_dict()))["not_restored"] == "the program"


def test_help_names_the_levels():
    text = run("probe", "--help").out
    assert "--memory" in text and "--plug" in text
