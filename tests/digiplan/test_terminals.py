"""Installation, appendices 2 and 3: direction and clock outputs, the supply of the outputs, cables, terminals."""

import re
from pathlib import Path
from typing import get_args

import pytest

from axistwin import Bench
from axistwin.bench.programs.keyboards import KEYBOARDS
from axistwin.controllers.digiplan.chapters.terminals import CABLES, TERMINALS
from axistwin.controllers.digiplan.options import Wiring
from axistwin.core.errors import UsageError

from .talking import command, edges, play, ready, send, times, until_idle, write

PAGE = Path(__file__).parents[2] / "docs" / "digiplan.md"

# Direction and clock outputs


def directions(if1):
    return [if1.pins[f"{axis}_direction"].level for axis in "xyz"]


def test_all_directions_are_high_at_first(bench, if1):
    """Default values: "All Direction O/P - High (open collector)"; so they are high without power, too."""
    for script, levels in (("0 s", [True] * 3), ("X-10$; idle", [False, True, True]), ("power off", [True] * 3)):
        play(bench, if1, script)
        assert directions(if1) == levels, script


def test_plus_is_high_and_minus_is_low(bench, if1):
    """Appendix 1: "+ Dir port high", "- Dir port low"; no sign means plus; the outputs of other axes do not change."""
    for text, levels in (
        ("X-Y+Z-10$", [False, True, False]),
        ("X$", [True, True, False]),
        ("Z/Y-5$", [True, False, True]),
    ):
        play(bench, if1, f"{text}; idle")
        assert directions(if1) == levels, text


def test_the_direction_is_there_before_the_first_pulse_and_turns_for_a_backlash_correction(bench, if1):
    """Backlash: the direction is set before the first of 30 steps, and changes in the pause before 10 steps back."""
    seen = edges(if1.pins["x_direction"])
    write(if1, "B+10", "X-20B@400$")
    until_idle(bench, if1)
    pulses = times(if1.axes["X"])
    assert (len(pulses), [level for _, level in seen]) == (40, [False, True])
    assert seen[0][0] < pulses[0] and pulses[29] < seen[1][0] < pulses[30]


def test_the_clock_is_high_for_5_us_from_each_pulse_on(bench, if1):
    """X clock: the manual gives no width; 5 µs is half a period at the highest speed, 100,000 steps/s."""
    write(if1, "X3Z3@400$")
    bench.run_until(lambda: if1.axes["X"].moving, 1)
    began_ns, clock = bench.now, bench.clock
    levels = {}
    for pulse_ns in (2_500_000, 5_000_000, 7_500_000):  # 400 steps/s
        for since_ns in (-1, 0, 4_999, 5_000):
            clock.run_to(began_ns + pulse_ns + since_ns)
            levels[pulse_ns, since_ns] = [if1.pins[f"{axis}_clock"].level for axis in "xyz"]
    assert {key[1] for key, level in levels.items() if level == [True, False, True]} == {0, 4_999}
    assert {key[1] for key, level in levels.items() if level == [False, False, False]} == {-1, 5_000}


def test_the_minor_axis_has_a_slower_clock(bench, if1):
    """Linear interpolation: in the same time X has 4 pulses and Y 2, at the second and the fourth of X."""
    write(if1, "X4/Y2@400$")
    bench.run_until(lambda: if1.axes["X"].moving, 1)
    began_ns, seen = bench.now, []
    for pulse in (1, 2, 3, 4):
        bench.clock.run_to(began_ns + pulse * 2_500_000)
        seen.append((if1.pins["x_clock"].level, if1.pins["y_clock"].level))
    assert seen == [(True, False), (True, True), (True, False), (True, True)]


def test_a_clock_output_can_be_forced_and_is_low_without_power(bench, if1):
    if1.pins["x_clock"].drive(True)
    assert if1.pins["x_clock"].level
    if1.pins["x_clock"].release()
    if1.power(False)
    assert not if1.pins["x_clock"].level


# The 24 V supply of the outputs


def test_without_the_24_v_supply_no_output_is_on(bench, if1):
    """Power requirements: the links are "necessary in order to power the opto-isolators on the interface outputs"."""
    play(
        bench, if1, "S135$; idle; supply low; outputs 00000; S2R3$; idle; outputs 00000; supply released; outputs 11001"
    )


def test_the_fault_output_needs_the_supply_too(bench):
    """Optional fault output: it duplicates the LED; the LED itself does not need the 24 V."""
    if1 = ready(bench, fault_output=True)
    play(bench, if1, "supply low; estop low; led is high; output5 is low; supply released; output5 is high")


def test_a_pulse_inverts_what_is_programmed_not_what_is_forced(bench, if1):
    """Output switching: the phase depends "on the prior state of the output", not on a level forced by a test lead."""
    if1.pins["output4"].drive(True)
    seen = edges(if1.pins["output4"])
    command(bench, if1, "P4,20$", seconds=0.1)
    if1.pins["output4"].release()  # during the pulse; it was reset, so it is on
    assert if1.pins["output4"].level
    bench.run(0.3)
    assert [level for _, level in seen] == [False]


# Cables


def test_every_cable_is_a_wiring():
    """Appendix 3 and the chapters on connections: each cable is a wiring with its name."""
    assert set(get_args(Wiring)) == CABLES.keys()
    with pytest.raises(UsageError, match="'Epson HX20 5-wire'"):
        Bench().add("if1", wiring="RS-423")


def test_unlinked_it_receives_and_transmits_nothing(bench):
    """Alternative connection methods: without links CTS and DSR "will be held negative": it "will not transmit"."""
    if1 = bench.add("if1", wiring="3-wire unlinked")
    bench.run(1.5)
    assert send(bench, if1, "(", seconds=1.0, end="") == b""
    assert not if1.terminals["dsr"].level and not if1.terminals["cts"].level and if1.terminals["rts"].level


# Where it is

LINES = {
    "input1": ("A12", "A", "current flows: +24 V"), "input2": ("C16", "A", "current flows: +24 V"),
    "input3": ("A16", "A", "current flows: +24 V"), "output1": ("C5", "D", "the transistor is on"),
    "output2": ("A6", "D", "the transistor is on"), "output3": ("C7", "D", "the transistor is on"),
    "output4": ("A8", "D", "the transistor is on"), "output5": ("C2", "D", "the transistor is on"),
    "estop": ("C13", "A", "current flows: +24 V, the switch is closed"),
    "limit_plus": ("C17", "A", "current flows: +24 V, the switch is closed"),
    "limit_minus": ("A17", "A", "current flows: +24 V, the switch is closed"),
    "supply": ("A10", "", "the outputs have their +24 V"),
    "x_fault": ("A13", "", "the drive is well, or its fault disable link is fitted"),
    "y_fault": ("C12", "", "the drive is well, or its fault disable link is fitted"),
    "x_direction": ("A3", "", "positive"), "y_direction": ("C3", "", "positive"), "z_direction": ("A4", "", "positive"),
    "x_clock": ("C20", "", "for 5 µs from each pulse on"), "y_clock": ("C21", "", "for 5 µs from each pulse on"),
    "z_clock": ("C19", "", "for 5 µs from each pulse on"), "dtr": ("A28", "", "set: +12 V"),
    "rts": ("C28", "", "set: +12 V"), "dsr": ("A27", "", "set: +12 V"), "cts": ("C27", "", "set: +12 V"),
}  # fmt: skip
"""Place on the edge of the card, type of circuit, meaning of a high level."""
LINKS = (
    ("links 1 and 2, motherboard", "the outputs take their +24 V from the drives", "pin `supply`"),
    ("link 3, motherboard", "simulates a working X drive", "pin `x_fault`: high, as fitted; low for a fault"),
    ("link 4, motherboard", "simulates a working Y drive", "pin `y_fault`: high, as fitted; low for a fault"),
    ("link 3, interface card", "position b: output 5 follows the LED", "option `fault_output = true`"),
)
"""Links, their purpose, and their counterpart in the emulation."""


def test_every_terminal_has_its_place(bench):
    """Appendix 2: the table of connectors and pins has every terminal."""
    assert bench.add("if1").terminals.keys() - {"led"} == TERMINALS.keys()


def test_the_page_has_every_terminal_link_and_cable():
    """The tables in docs/digiplan.md are those of the code."""
    rows = set(re.findall(r"^\|.*\|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert LINES.keys() == TERMINALS.keys()
    for name, place in TERMINALS.items():
        assert f"| `{name}` | {place} | {' | '.join(LINES[name])} |" in rows
    for link in LINKS:
        assert f"| {' | '.join(link)} |" in rows
    for name, cable in CABLES.items():
        assert f'| `"{name}"` | {cable.purpose} |' in rows
    for name, glyphs in KEYBOARDS.items():
        assert f"| `{name}` | " + " | ".join(f"`{glyph}`" for glyph in glyphs) + " |" in rows


# Hints


def test_it_tells_that_it_drops_what_comes_before_the_baud_rate_is_known(bench):
    """Initialisation: commands sent before `(` are dropped, and one hint about it is given."""
    if1, told = bench.add("if1"), []
    if1.subscribe_hint(told.append)
    play(bench, if1, "1.5 s; X1000$; 0.2 s")
    assert told == ["characters from the host are dropped, no baud rate yet: send ( first, at 110 to 9600 baud"]
    assert if1.hint == told[0]
    play(bench, if1, "( -> U<CR>")
    assert if1.hint == "" and len(told) == 1


def test_it_tells_that_it_drops_what_comes_before_the_data_format(bench):
    """Initialisation: a command before the format is dropped with a hint; a `U` sent back (sample 4) gives none."""
    if1, told = bench.add("if1"), []
    if1.subscribe_hint(told.append)
    play(bench, if1, "1.5 s; ( -> U<CR>; U; 0.1 s")
    assert told == []
    play(bench, if1, "X1000$; E; 0.1 s")
    assert told == ["characters from the host are dropped, no data format yet: send it first, e.g. U61 <CR>"]
    play(bench, if1, "U61; 1.2 s")
    assert if1.hint == "" and len(told) == 1


def test_unsubscribing_from_hints(bench):
    """After unsubscribing, no hint is received."""
    if1, told = bench.add("if1"), []
    end = if1.subscribe_hint(told.append)
    end()
    bench.run(1.5)
    command(bench, if1, "X1000$")
    assert told == []


def test_a_board_has_no_hints_of_its_own(bench):
    """Every controller has `subscribe_hint`; a board never gives a hint."""
    bench.add("1811").subscribe_hint(print)()
