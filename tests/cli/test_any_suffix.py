"""With MODEL, a program may have any suffix; a compiled program of a SmartMotor is named for what it is."""

import os

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

from ..command import run


@pytest.mark.parametrize(("model", "text", "moved"), [
    ("if1", "X100$\n", "X 0 → 100"), ("if1", ">2@50000\nX100$\n", "X 0 → 100"),
    ("1811", "31 00 00 00 00 27 10 00 00 27 10\n33 00 00 00 64\n", "motor 0 → 100"),
    ("SmartMotor", "UCI UDI ZS A=100 V=100000 P=200 G TWAIT END\n", "shaft 0 → 200")])  # fmt: skip
def test_a_program_of_the_model_may_have_any_name(tmp_path, model, text, moved):
    for name in ("moves.txt", "moves", "MOVES.PRG"):
        file = tmp_path / name
        file.write_text(text)
        done = run("run", model, file)
        assert (done.code, moved in done.out) == (0, True), done.err
        assert run("check", model, file).code == 0


def test_what_is_wrong_in_it_is_told_as_in_a_file_with_the_usual_suffix(tmp_path):
    (tmp_path / "a.txt").write_text("X100$\nx\n")
    done = run("run", "if1", tmp_path / "a.txt")
    assert done.code == 1 and "DP101" in done.out
    assert ":2:1: error" in run("check", "if1", tmp_path / "a.txt").out


def test_without_a_model_the_suffix_decides(tmp_path):
    (tmp_path / "a.txt").write_text("X100$\n")
    done = run("check", tmp_path / "a.txt")
    assert done.code == 2 and "unknown controller model: expected the argument MODEL" in done.err


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_compiled_program_is_named_for_what_it_is(tmp_path, command):
    (tmp_path / "home.smx").write_bytes(b"$12\x00\x01")
    done = run(command, "smartmotor", tmp_path / "home.smx")
    assert done.code == 2 and "home.smx is a compiled SmartMotor program: expected its source, a .sms file" in done.err


def test_a_text_at_the_serial_port_is_refused_with_what_is_expected():
    with pytest.raises(
        UsageError, match=r"write\('X100\$'\): expected bytes, e.g. write\(b'...'\) or write\(text.encode"
    ):
        Bench().add("if1").serial.write("X100$")


@pytest.mark.parametrize("command", [("run", "if1"), ("check", "if1"), ("check", "if1", "--diff")])
def test_a_program_may_come_by_the_standard_input(command):
    done = run(*command, "-", typed="X100$\nx\n")
    assert done.code == 1 and "-:2:1" in done.out + done.err
    assert "axistwin check if1 -" in done.err or command[0] == "check"


@pytest.mark.parametrize(("arguments", "text"), [
    (("if1",), "> (U61\\r\n> x\\r\n"), (("1811",), "; model: 1811\n+1\n> 33 00 00 00 01\n+1\n"),
    ((), "; model: if1\n> (U61\\r\n> x\\r\n"), (("smartmotor",), "+1\nsmartmotor: > FLY\\r\n")])  # fmt: skip
def test_a_conversation_is_recognised_by_its_lines(arguments, text, tmp_path):
    (tmp_path / "a.txt").write_text(text)
    by_input, by_file = run("check", *arguments, "-", typed=text), run("check", *arguments, tmp_path / "a.txt")
    assert by_input.code == by_file.code == 1
    assert by_input.out == by_file.out.replace(str(tmp_path / "a.txt"), "-") and by_input.out.count("\n") == 1
    assert run("run", *arguments, "-", typed=text).code == 1 or not arguments


def test_the_standard_input_cannot_be_fixed_but_its_fixes_are_shown():
    done = run("check", "if1", "-", "--fix", typed="x1$\n")
    assert (done.code, done.err) == (
        2, "axistwin: the standard input cannot be fixed: expected a file, or --diff instead of --fix\n",
    )  # fmt: skip
    assert "+X1$" in run("check", "if1", "-", "--diff", typed="x1$\n").out


def test_a_pipe_in_the_place_of_a_program_is_refused_at_once(tmp_path):
    for name in ("a.sms", "a.if1", "a"):
        os.mkfifo(tmp_path / name)
        done = run("check", "smartmotor" if name == "a.sms" else "if1", tmp_path / name)
        assert (done.code, "expected an ordinary file" in done.err) == (2, True)
