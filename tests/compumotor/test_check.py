"""`check` for an 1810 or 1811: it reports commands that the board would ignore without a message."""

import json

import pytest

from axistwin.cli.program import main

DEFAULT = "31 00 00 00 00 61 A8 00 03 D0 90"
VELOCITY_DISTANCE = "51 01 04 00 00 00 00"


@pytest.fixture
def check(tmp_path, capsys):
    def check(*lines, model="1811", suffix="181x"):
        program = tmp_path / f"program.{suffix}"
        program.write_text("\n".join(lines))
        with pytest.raises(SystemExit):
            main(["check", model, str(program), "--json"])
        found = json.loads(capsys.readouterr().out)["diagnostics"]
        return [f"{d['line']}:{d['column']} {d['severity']} {d['message']}" for d in found]

    return check


@pytest.mark.parametrize(("lines", "found"), [
    (["02"], "1:1 error no command 02"),
    (["33 00"], "1:4 error go_relative (33) has 1 parameter byte: expected 4"),
    (["70 00 00 01"], "1:10 error surplus byte 01: expected 00 after the 0 bytes of the parameters"),
    (["08 08"], "1:4 error 08 is out of range: expected bits 0…7"),
    ([f"{DEFAULT[:-1]}0", "33 80 00 00 00"], "2:4 error 80 00 00 00 is out of range"),
    (["set_user_bit 3"], "1:14 error invalid bit '3'"),
    (["nonsense"], "1:1 error no command 'nonsense'"),
    (["FE"], "1:1 warning"),
    (["D9 01", "70", "D8"], "2:1 error stop (70) is not allowed in a sequence"),
    (["wait_seconds 2"], "1:1 error wait_seconds (2A) is valid in a sequence only"),
    (["D9 01", "repeat 3 2", "repeat 1 2", "83", "83", "D8"], "3:1 error ignored: loops cannot be nested"),
    (["D9 01", "repeat 3 2", "83", "D8"], "2:1 warning the loop repeats 3 commands, but 1 follow"),
    (["D9 01", "83"], "1:1 warning the definition of this sequence never ends"),
    (["D8"], "1:1 warning no sequence is being defined"),
    (["40 07"], "1:4 error move 7 is not defined here"),
    (["D9 01", "40 07", "D8", "41 01"], "2:4 error move 7 is not defined here"),
    (["41 02"], "1:4 error sequence 2 is not defined here"),
    (["33 00 00 00 01"], "1:1 error ignored: 31 (default velocity and acceleration)"),
    ([DEFAULT, "39 00"], "2:1 error ignored: 38 (define home)"),
    ([DEFAULT, "35 00 00 00 01"], "2:1 error ignored: B0 (ratio), B1 (resolution)"),
    (["31 00 00 00 10 00 00 00 00 00 01"], "1:10 error velocity 1048576 is beyond range 0: expected at most 546133"),
    (["define_relative_move 51 00 1 1 1"], "1:22 error move 51 is not stored"),
    (["E0" + " 00" * 12], "1:1 error velocity_distance_data (E0) is valid in a streaming mode only"),
    ([VELOCITY_DISTANCE, "40 01"], "2:1 error perform_move (40) is not valid in a streaming mode"),
    ([VELOCITY_DISTANCE, "E1" + " 00" * 14], "2:1 error ignored: data for mode 52, but the present mode is 51"),
    ([VELOCITY_DISTANCE, "E0 10 00 00 01" + " 00" * 8], "2:4 error this pair lasts 0.0146 ms"),
    (["53 01 04 00 00 00 00 00 02", "E3 01 7F FF" + " 00" * 12], "2:7 error 32767 pulses in 2 ms exceed the clock"),
    ([VELOCITY_DISTANCE, "EE 7F FE 7C 01 01"], "2:10 error 7C cannot be in a marker"),
    (
        ["stop_on_trigger 1 on off", "interrupt_on_trigger 1 on"],
        "2:1 error ignored: trigger 1 already has the function 74",
    )])  # fmt: skip
def test_what_is_wrong(check, lines, found):
    (diagnostic,) = check(*lines)
    assert diagnostic.startswith(found)


def test_nothing_wrong(check):
    assert check(
        "; a program", DEFAULT, "go_relative 25000", "+1", "! trigger1 low",
        "define_relative_move 1 00 1000 1000 5", "D9 01", "repeat 2 3", "40 01", "83", "D8", "41 01", "70 00",
        "53 01 04 00 00 00 00 00 02", "E3 02 00 10 80 01" + " 00" * 10, "EE 7F FE 09 01 00", "50", "perform_move 1",
    ) == []  # fmt: skip


def test_switching_off_forgets(check):
    (diagnostic,) = check(DEFAULT, "! power off", "! power on", "33 00 00 00 01")
    assert diagnostic.startswith("4:1 error")


def test_an_1810_has_no_encoder(check):
    (diagnostic,) = check(DEFAULT, "35 00 00 00 01", model="1810")
    assert diagnostic.startswith("2:1 error no command 35")


def test_a_conversation(check):
    (diagnostic,) = check("; model: 1811", "+1.1", "> 08 01", "> 08 09", "< 83", suffix="talk")
    assert diagnostic.startswith("4:6 error 09 is out of range")


CLOSED_LOOP = "D4 01 00 00 00 61 A8 00 03 D0 90 00 00 00 0A"


def test_a_closed_loop_move_needs_the_ratio(check):
    """D4h: "this move may only be performed after the motor pulse to encoder pulse ratio has been defined"."""
    ratio = "B0 61 A8 0F A0"
    (diagnostic,) = check(CLOSED_LOOP, "40 01", ratio, "40 01")
    assert diagnostic.startswith("2:1 error ignored: B0 (ratio) must be sent first")
    assert check(ratio, CLOSED_LOOP, "D9 01", "40 01", "D8", "41 01") == []
    (diagnostic,) = check(ratio, CLOSED_LOOP, "D7 01", "40 01")
    assert diagnostic.startswith("4:4 error move 1 is not defined here")


def test_an_1810_performs_no_closed_loop_move(check):
    """Addendum: the software "is identical", but there is no encoder; see option `encoder_commands`."""
    (diagnostic,) = check("B0 61 A8 0F A0", CLOSED_LOOP, "40 01", model="1810")
    assert diagnostic.startswith("3:1 warning not performed: move 1 is a closed-loop move")
    open_loop = "C8" + CLOSED_LOOP[2:]
    assert check(CLOSED_LOOP, open_loop, "40 01", model="1810") == []


@pytest.mark.parametrize("ignored", ["D9 01", "DA 01", "92 01"])
@pytest.mark.parametrize("move", ["33 00 00 00 01", "32 00", "perform_move 1", "41 02"])
def test_a_definition_right_after_a_move_is_ignored(check, ignored, move):
    """92h, D9h, DAh are SINGULAR: none begins while the host's move or a sequence is performed; a wait helps."""
    before = (DEFAULT, "define_relative_move 1 00 1000 1000 5", "D9 02", "83", "D8")
    after = ("83", "D8") if ignored[:2] == "D9" else ()
    (diagnostic,) = check(*before, move, ignored, *after)
    assert diagnostic.startswith("7:1 warning ignored during ")
    assert check(*before, move, "+1", ignored, *after) == [] and check(*before, ignored, *after, move) == []
