"""The text form of commands and messages."""

import pytest

from axistwin.bench import product
from axistwin.controllers.compumotor.checker.texts import LAYOUTS, SPECIAL, Words, name_of
from axistwin.controllers.compumotor.commands import COMMANDS_1811
from axistwin.controllers.compumotor.language import Opcode
from axistwin.core.errors import ProgramError

WORDS = Words(product("1811").commands)


@pytest.mark.parametrize(("text", "command"), [
    ("33 00 00 61 A8", "33 00 00 61 a8"), ("33000061a8 ; a revolution", "33 00 00 61 a8"),
    ("go_relative 25000", "33 00 00 61 a8"), ("go_relative -1", "33 ff ff ff ff"),
    ("go_relative 0x61A8", "33 00 00 61 a8"), ("stop", "70"),
    ("default_velocity_and_acceleration 51 1000 2000", "31 00 51 00 00 03 e8 00 00 07 d0"),
    ("define_continuous_move 7 00 1 2 1", "ce 07 00 00 00 00 01 00 00 00 02 01"),
    ("define_home high 1 20 -", "38 01 01 14 01"), ("repeat 3 500", "20 03 01 f4"),
    ("go_relative_encoder 4", "35 00 00 00 04"), ("interrupt_at_next_hit_of_plus_limit on", "a8 01")])  # fmt: skip
def test_a_command(text, command):
    assert WORDS.read(text) == bytes.fromhex(command)


@pytest.mark.parametrize(("text", "column", "message"), [
    ("", 1, "the command is missing"),
    ("33 0", 4, "'0' is not a byte"),
    ("33 00 gg", 7, "'gg' is not a byte"),
    ("go_relativ 3", 1, "did you mean go_relative"),
    ("jump", 1, "no command 'jump'"),
    ("go_relative", 1, "wrong number of values for the command go_relative: expected distance"),
    ("stop 1", 1, "wrong number of values for the command stop: expected no value"),
    ("go_relative far", 13, "invalid distance 'far'"),
    ("perform_move 51", 14, "invalid move '51': expected a number, move 1…50"),
    ("define_relative_move 1 60 1 1 1", 24, "expected the digits of velocity range (0 to 5)"),
    ("write_user_bits 8", 17, "invalid bits '8'"),
    (" ".join(["00"] * 17), 49, "at most 16 bytes")])  # fmt: skip
def test_what_is_no_command(text, column, message):
    with pytest.raises(ProgramError) as error:
        WORDS.read(text)
    assert message in str(error.value) and error.value.column == column


@pytest.mark.parametrize(("message", "words"), [
    ("01 2a", "interrupt: identifier 42"),
    ("74 06", "stop on trigger: trigger 6"),
    ("80 ff ff ff ff", "position from start of move: position -1 pulses"),
    ("83 ff ff ff ff 9e 58", "position from absolute zero: position -25000 pulses"),
    ("84 ff", "direction: -"),
    ("85 10 00 00 61 a8", "velocity: ranges 10, velocity 25000"),
    ("85 01 2c", "velocity: velocity 300 effective clock/65536"),
    ("85 81 2c", "velocity: velocity CCW 300 effective clock/65536"),
    ("85 81 00", "velocity: velocity CCW 256 effective clock/65536"),
    ("88 31", "move status: + limit, moving, constant velocity"),
    ("89 f0", "limits: +"),
    ("8c ff", "moving: yes"),
    ("90 50", "mode: indexer mode"),
    ("92 2a 00 02", "list sequence: wait seconds: time 2 s"),
    ("92", "list sequence: end of the list"),
    (
        "91 ce 00 00 00 00 00 64 00 00 00 c8",
        (
            "move parameters: define continuous move: move 0, ranges 00, velocity 100 units of range, "
            "acceleration 200 units of range, direction 0"
        ),
    ),
    ("94 14", "triggers: 2, 4 high"),
    ("95 00", "joystick request: yes, the input is low"),
    ("95 ff", "joystick request: no, the input is high"),
    ("97 04", "outputs: 2 set"),
    ("a4", "interrupt at next end of motion"),
    ("51 01 04 00 00 00 64", "velocity-distance streaming mode: base clock 1, divisor 4, alarm 100 bytes"),
    ("e2 00 00 02 58", "free bytes: bytes 600"),
    ("fd 39 34", "part number: 94"),
    ("02", "means nothing")])  # fmt: skip
def test_a_message(message, words):
    assert Words(COMMANDS_1811).explain_message(bytes.fromhex(message).ljust(16, b"\0")) == words


def test_a_streamed_velocity_has_a_direction():
    """E0h, E1h: "The most significant bit is the sign bit, 1 = CCW motion and 0 = CW motion"."""
    pairs = "8008 0064 7FFF 0001 8000 0000"
    assert WORDS.explain(bytes.fromhex(f"E0 {pairs}")) == "velocity-distance data: " + ", ".join(
        f"velocity {velocity} effective clock/65536, distance {distance} pulses"
        for velocity, distance in (("CCW 8", 100), ("32767", 1), ("CCW 0", 0))
    )
    same = WORDS.explain(bytes.fromhex("E1 0008 8019 0000 0000 0000 0000 0000"))
    assert same == "velocity-time data: velocity 8, CCW 25, 0, 0, 0, 0, 0 effective clock/65536"
    command = WORDS.commands.get(0xE1)
    assert str(command.fields[0]) == "velocity 0…32767 effective clock/65536, CCW 32768 more"


def test_names_are_different_and_no_hex():
    names = [name_of(command) for command in WORDS.commands if isinstance(command, Opcode)]
    assert len(set(names)) == len(names) == len(WORDS.commands)
    assert not [name for name in names if set(name) <= set("0123456789abcdef")]


def test_every_message_can_be_told():
    for opcode in (*LAYOUTS, *SPECIAL):
        assert Words(COMMANDS_1811).explain_message(bytes([opcode]).ljust(16, b"\xff"))
