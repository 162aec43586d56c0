"""Registers: the values of the report-back commands, read at any time without a command."""

import pytest

from .talking import ask, command, ready, write

ASKED = ("E", "K", "F", "I", "O", "N")


def test_a_register_that_is_a_text_says_so(bench, if1):
    """Busy status: the registers E and state are marked as texts; the others are numbers."""
    for name, register in if1.registers.items():
        assert register.text is isinstance(register.read(), str), name
    assert {name for name, register in if1.registers.items() if register.text} == {"state", "E"}


def test_what_changes_while_nothing_happens_says_so(bench, if1):
    """Quick status, position: such registers, which change without an event during a motion, are marked so."""
    write(if1, "X@20000G$")
    seen = []
    for seconds in (0.01, 0.5, 3):
        bench.run(seconds)
        seen.append({name: register.read() for name, register in if1.registers.items()})
    changing = {name for name in seen[0] if len({values[name] for values in seen[1:]}) > 1}
    assert changing == {name for name, register in if1.registers.items() if register.restless} == {"Q", "N"}


SITUATIONS = {
    "at rest": (), "locked": ("[",), "in a sequence": (":X5:P0,90:$",), "with a data fault": ("W",),
    "after an index": ("X77$",), "waiting": ("H1X5$",),
}  # fmt: skip


@pytest.mark.parametrize("messages", SITUATIONS.values(), ids=SITUATIONS)
def test_they_are_what_the_commands_report(bench, messages):
    """Report-back functions: registers equal the answers, and reading a register clears nothing."""
    if1 = ready(bench)
    for message in messages:
        command(bench, if1, message, seconds=0.5)
    read = {name: if1.registers[name].read() for name in ASKED}
    assert read == {name: if1.registers[name].read() for name in ASKED}
    told = {name: ask(bench, if1, name, 0.02).decode().rstrip("\r") for name in ASKED}
    assert told == {name: str(value) for name, value in read.items()}


def test_without_power_there_is_nothing(bench, if1):
    command(bench, if1, "W", "X5$", seconds=0.5)
    if1.power(False)
    values = {name: register.read() for name, register in if1.registers.items()}
    assert values == {**dict.fromkeys(values, 0), "state": "off", "E": "off"}
