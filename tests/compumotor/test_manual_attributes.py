"""Command definitions, paragraph by paragraph: when each command is valid, and the ranges of its parameter bytes."""

from pathlib import Path

import pytest

from axistwin.bench import product
from axistwin.controllers.compumotor.language import Accept

from .talking import position, ready

LIST = Path(__file__).parents[1] / "manual" / "1811_attributes.txt"
ROWS = [line.split() for line in LIST.read_text().splitlines() if not line.startswith("#")]
PRINTED = {
    "S": Accept.SINGULAR, "I": Accept.INDEXER, "V": Accept.STREAMING, "Q": Accept.SEQUENCE, "C": Accept.DURING_SEQUENCE,
    "W": Accept.DURING_STREAMING,
}  # fmt: skip
ALL = Accept.SINGULAR | Accept.INDEXER | Accept.STREAMING | Accept.SEQUENCE
ALL |= Accept.DURING_SEQUENCE | Accept.DURING_STREAMING


def table(code: str):
    return product("1811").commands.get(int(code, 16))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_a_command_is_valid_where_the_manual_says_so(row):
    """Command definitions: "VALID-in-INDEXER-mode", "VALID-within-a-SEQUENCE-buffer" and so on, below each command."""
    attributes = Accept(0)
    for letter in row[1]:
        attributes |= PRINTED[letter]
    assert table(row[0]).accepted & ALL == attributes


def test_what_acts_during_a_definition_and_what_needs_the_encoder():
    """D9h: commands are stored "until" D8h; only FFh acts at once, 00h does nothing; addendum: the 1811 only."""
    defining = {c.code for c in product("1811").commands if Accept.DEFINING in c.accepted}
    assert {0xD8, 0xFF} <= defining <= {0x00, 0xD8, 0xFF}
    encoder = {c.code for c in product("1811").commands if Accept.ENCODER in c.accepted}
    assert encoder == {0x35, 0x36, 0x37, 0x3A, 0xB5}  # an 1810 keeps 2Fh, D4h and D5h too


RANGES = """
01 00 FF |
08 00 07 | 08 FF
09 00 02 | 03 FF
0A 00 02 | 03 FF
0B 01 02 | 00 03
0C 01 02 | 00 03
0D 00 FF |
0F 000000 040000 02FF01 | 050000 FF0000
20 010001 FFFFFF 01FFFF | 000001 010000
21 01 FF | 00
29 00000001 FFFFFFFF | 00000000
2A 0001 FFFF | 0000
2B 0001 FFFF | 0000
2C 0100 06FF | 0000 0700
2E 80000000 7FFFFFFF |
33 80000001 7FFFFFFF | 80000000
34 C0000001 3FFFFFFF | C0000000 40000000 80000000
35 80000001 7FFFFFFF |
38 00000100 FFFF64FF | 00000000 00006500
40 01 32 | 00 33 FF
41 01 0F | 00 10
51 010100000000 0910FFFFFFFF | 000100000000 0A0100000000 010000000000 011100000000
52 0101000000000002 0910FFFFFFFFFFFF | 0001000000000002 0A01000000000002 0101000000000001 0100000000000002
53 0101000000000002 0310FFFFFFFFFFFF | 0001000000000002 0401000000000002 0111000000000002 0101000000000000
74 010000 06FFFF | 000000 020000 050000 070000
75 010000 06FFFF | 000000 030000 070000
7C 010000 06FFFF | 000000 040000 070000
7F 010000 06FFFF | 000000 020000 070000
92 01 0F | 00 10
AC 0100 06FF | 0000 0200 0500 0700
D7 01 FF | 00
D9 01 0F | 00 10
DA 01 0F | 00 10
B1 0000FFFF | 00010000 01000000
B4 0000FFFF | 00010000 01000000
D6 00000000 7FFFFFFF | 80000000 FFFFFFFF
EE 0001000000 FFFFFFFFFF | 0000000000
"""
"""Typed from the command definitions: opcode, parameter strings that are valid, and behind the bar invalid ones."""


def strings(side: int):
    for line in RANGES.split("\n"):
        if line:
            code, *texts = line.split("|")[0].split() if side == 0 else (line[:2], *line.split("|")[1].split())
            yield from ((code, text) for text in texts)


@pytest.mark.parametrize(("code", "text"), list(strings(0)))
def test_the_ends_of_the_ranges_are_valid(code, text):
    """Command definitions: "01 -> 32, move number", "01 -> 0F", "00 -> FF" and so on: both ends are valid."""
    assert table(code).decode(bytes.fromhex(text)) is not None


@pytest.mark.parametrize(("code", "text"), list(strings(1)))
def test_what_lies_beyond_the_ranges_is_invalid(code, text):
    """Command language syntax: parameter bytes "must be in the correct range, or the command cannot be interpreted"."""
    assert table(code).decode(bytes.fromhex(text)) is None


def test_the_ends_of_every_range_are_numbers_of_its_bytes():
    """Parameters with a range: both ends are stated, and are the same number after the way through the bytes."""
    numbers = [f for c in product("1811").commands for f in c.fields if (f.low, f.high) != (None, None)]
    assert len(numbers) > 50 and [f for f in numbers for end in (f.low, f.high) if f.decode(f.encode(end)) != end] == []


def moves(number=1, ranges=0, velocity=0, acceleration=0, rest=b""):
    return bytes([number, ranges]) + velocity.to_bytes(4) + acceleration.to_bytes(4) + rest


@pytest.mark.parametrize("code", ["C8", "CB", "D4", "D5", "CE"])
def test_a_move_is_defined_within_its_ranges_only(code):
    """C8h to CEh: the move number is "01 -> FF", the range digits are 0 to 5 and 0 to 2, and no value is negative."""
    rest = b"\0" if code == "CE" else bytes(4)
    highest = 0x7FFF_FFFF
    for good in (moves(rest=rest), moves(0xFF, 0x52, highest, highest, rest)):
        assert table(code).decode(good) is not None
    bad = {
        "move 00": moves(0, rest=rest), "velocity range 6": moves(ranges=0x60, rest=rest),
        "acceleration range 3": moves(ranges=0x03, rest=rest), "velocity": moves(velocity=highest + 1, rest=rest),
        "acceleration": moves(acceleration=highest + 1, rest=rest), "a byte short": moves(rest=rest)[:-1],
        "a surplus byte": moves(rest=rest) + b"\1",
    }  # fmt: skip
    assert [name for name, data in bad.items() if table(code).decode(data) is not None] == []


@pytest.mark.parametrize(("code", "good", "bad"), [
    ("C8", (0x80000001, 0x7FFFFFFF), (0x80000000,)), ("CB", (0xC0000001, 0x3FFFFFFF), (0xC0000000, 0x40000000))
])  # fmt: skip
def test_the_distance_of_a_move(code, good, bad):
    """C8h: "80000000h is invalid"; CBh: "C0000001h through 3FFFFFFFh"."""
    assert all(table(code).decode(moves(rest=distance.to_bytes(4))) is not None for distance in good)
    assert all(table(code).decode(moves(rest=distance.to_bytes(4))) is None for distance in bad)


@pytest.mark.parametrize(("code", "units"), [
    ("29", {"ms"}), ("2A", {"s"}), ("2B", {"min"}), ("33", {"pulses"}), ("34", {"pulses"}),
    ("35", {"encoder pulses"}),
    ("36", {"encoder pulses"}), ("38", {"%"}), ("51", {"bytes"}), ("52", {"bytes", "ms"}), ("2E", {"pulses"}),
    ("2F", {"encoder pulses"})])  # fmt: skip
def test_the_units_of_parameters(code, units):
    """Command definitions: "wait X milliseconds", "X seconds", "X minutes", "X pulses", "X encoder pulses", percent."""
    assert {field.unit for field in table(code).parameters} - {""} == units


@pytest.mark.parametrize(("code", "syntax"), [
    ("29", "29 time[4]"), ("2A", "2A time[2]"), ("41", "41 sequence"),
    ("C8", "C8 move ranges velocity[4] acceleration[4] distance[4]"),
    ("52", "52 base clock divisor alarm[4] update rate[2]")])  # fmt: skip
def test_the_syntax_that_is_listed(code, syntax):
    """Command definitions: each parameter with its number of bytes, from the most significant byte to the least."""
    assert table(code).syntax == syntax


@pytest.mark.parametrize("opcode", [0x80, 0x81, 0x82, 0x83])
@pytest.mark.parametrize("model", ["1810", "1811"])
def test_positions_are_zero_after_power_up(bench, model, opcode):
    """82h: "After power up or reset the HOME limit switch position is" that of the motor: all positions are 0."""
    assert position(bench, ready(bench, model), opcode) == 0
