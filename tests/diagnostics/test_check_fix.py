"""`axistwin check --fix`: the applied fixes; a file is replaced completely or not at all."""

import os
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.bench import product
from axistwin.cli.program import axistwin
from axistwin.controllers.diagnostics import Edit
from axistwin.core.errors import AxistwinError
from axistwin.scenes.diagnostics import fix as check_fix
from axistwin.scenes.diagnostics.checking import diagnose_text

from ..told import raises


@pytest.fixture
def fix(tmp_path, monkeypatch):
    """Return a function that writes a file and fixes it, and returns the output and the new contents."""
    monkeypatch.chdir(tmp_path)

    def run(name, data, *options):
        Path(name).write_bytes(data if isinstance(data, bytes) else data.encode())
        arguments = ["check", name, "--fix", *options]
        result = CliRunner().invoke(axistwin, arguments, catch_exceptions=False, standalone_mode=False)
        return result, Path(name).read_bytes().decode("latin-1" if name.endswith(".sms") else "utf-8")

    return run


MENDED = {
    # IF1 and IF2
    ("a.if1", "x100@5y-$\n"): "X100@5Y-$\n",
    ("a.if1", ":X100"): ":X100:$",
    ("a.if1", ":X100$ ; a sequence\r\n"): ":X100:$ ; a sequence\r\n",
    ("a.if1", ":X100: $\n"): ":X100: $\n",
    ("a.if1", "X-1000 @500 G $\n"): "X- @500 G $\n",
    ("a.talk", "; model: if1\n> (U61\\r\n> x10\\x30$\\r\n"): "; model: if1\n> (U61\\r\n> X10\\x30$\\r\n",
    # 1810 and 1811
    ("a.181x", "Null\nset-user-bit 1 ; one\n"): "null\nset_user_bit 1 ; one\n",
    # SmartMotor
    ("a.sms", "A100 a5\n"): "A=100 a=5\n",
    ("a.sms", "a = 1 b= 2 c =3\n"): "a=1 b=2 c=3\n",
    ("a.sms", "IF a b=1 endif\n"): "IF a b=1 ENDIF\n",
    ("a.sms", "-----\na=1\n"): "'-----\na=1\n",
    ("a.sms", "aw[0] 1 2 3\n"): "aw[0] 1 2 3.\n",
    ("a.sms", "ES400 a=1\n"): " a=1\n",
    ("a.sms", "EIGN(W,0) ZS MP PT=100 G\n"): "UCI UDI ZS MP P=100 G\n",
    ("a.sms", "F=32 END C1 RETURN\n"): "F=32 END C1 RETURNF\n",
}


@pytest.mark.parametrize(("name", "text"), MENDED)
def test_fixes(fix, name, text):
    result, mended = fix(name, text)
    assert mended == MENDED[name, text]
    assert result.return_value == 0 and ("fixed" in result.stdout) == (mended != text)


@pytest.mark.parametrize(("name", "text"), [
    ("a.if1", "next$\n"), ("a.if1", "X100\n"), ("a.if1", "S2\n"), ("a.181x", "go_relatve 25000\n"),
    ("a.sms", "end of the loop\n"), ("a.sms", "----- a=1\n"), ("a.sms", "UCI UDI G\n"), ("a.sms", "a =\n 1\n"),
    ("a.sms", "a= S\n"), ("a.sms", "VT=5 ADT=5\n")])  # fmt: skip
def test_fixes_that_need_a_decision_are_not_applied(fix, name, text):
    result, mended = fix(name, text)
    assert mended == text and "fixed" not in result.stdout


def test_the_output_lists_applied_fixes_and_remaining_errors(fix):
    result, _ = fix("moves.if1", "x100$\n@30000$\n")
    assert result.stdout.splitlines() == [
        "moves.if1:1:1: fixed DP101: write X",
        "moves.if1: the old program is in moves.if1.bak",
        "moves.if1:2:1: error: speed 30000 is above 25000 steps/s, the maximum of range 1 (manual: Speed) [DP301]",
    ]
    assert (result.stderr, result.return_value) == ("axistwin: moves.if1: 1 error\n", 1)


def test_json_on_standard_output_is_not_mixed_with_messages(fix):
    result, _ = fix("moves.if1", "x100$\n", "--json")
    assert result.stdout.startswith("{")
    assert result.stderr.splitlines() == [
        "moves.if1:1:1: fixed DP101: write X", "moves.if1: the old program is in moves.if1.bak",
    ]  # fmt: skip


def test_line_ends_encoding_and_permissions_are_kept(fix, tmp_path):
    Path("home.sms").touch(mode=0o640)
    os.chmod("home.sms", 0o640)
    _, mended = fix("home.sms", "A100 'gr\xfc\xdfe\r\nEND".encode("latin-1"))
    assert mended == "A=100 'gr\xfc\xdfe\r\nEND"
    for name in ("home.sms", "home.sms.bak"):
        assert Path(name).stat().st_mode & 0o777 == 0o640
    assert sorted(each.name for each in tmp_path.iterdir()) == ["home.sms", "home.sms.bak"]


def test_every_backup_has_the_program_before_its_fixes(fix):
    """A backup is never overwritten: the first one is the old program itself."""
    old = "A100 'gr\xfc\xdfe\r\nEND\x1arest".encode("latin-1")
    result, _ = fix("home.sms", old)
    assert result.stdout.splitlines()[-1] == "home.sms: the old program is in home.sms.bak"
    fix("home.sms", b"A200\n")
    assert Path("home.sms.bak").read_bytes() == old and Path("home.sms.bak2").read_bytes() == b"A200\n"


def test_a_backup_that_cannot_be_written_leaves_the_program(fix, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("axistwin.scenes.diagnostics.fix.write_whole", full)
    raises(AxistwinError, "moves.if1 cannot be written: no space left on device", fix, "moves.if1", "x1$\n")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("moves.if1", "x1$\n")]


WRONG = "moves.if1:2:1: error: unknown character 'x': commands are upper case (manual: Full command list) [DP101]"


def test_a_difference_is_shown_and_nothing_is_written(fix, tmp_path):
    result, text = fix("moves.if1", "+1\nx100$\r\n@30000$\n", "--diff")
    assert text == "+1\nx100$\r\n@30000$\n"
    assert result.stdout.splitlines() == [
        "--- moves.if1", "+++ moves.if1 (fixed)", "@@ -1,3 +1,3 @@", " +1", "-x100$", "+X100$", " @30000$",
        WRONG,
        "moves.if1:3:1: error: speed 30000 is above 25000 steps/s, the maximum of range 1 (manual: Speed) [DP301]",
    ]  # fmt: skip
    assert (result.return_value, [each.name for each in tmp_path.iterdir()]) == (1, ["moves.if1"])
    result, _ = fix("moves.if1", "x100$\n", "--diff", "--json")
    assert result.stdout.startswith("{") and result.stderr.startswith("--- moves.if1\n+++ ")
    assert "---" not in fix("moves.if1", "X100$\n", "--diff")[0].stdout


def test_a_difference_is_printable(fix):
    result, _ = fix("home.sms", "A100 '\x1b[31m\n", "--diff")
    assert r"+A=100 '\x1b[31m" in result.stdout.splitlines()


@pytest.mark.parametrize(("name", "text", "mended"), [
    ("a.if1", "x100$\r\n\x1a", "X100$\r\n\x1a"), ("a.if1", "X100$\r\n\x1a", "X100$\r\n\x1a"),
    ("a.sms", "A100\r\nEND\r\n\x1a\x1aA100", "A=100\r\nEND\r\n\x1a\x1aA100"),
    ("a.talk", "; model: if1\r\n> (U61\\r\r\n\x1a\0\0", "; model: if1\r\n> (U61\\r\r\n\x1a\0\0"),
    ("a.181x", "Null\r\n\x1a", "null\r\n\x1a")])  # fmt: skip
def test_a_program_that_ends_in_ctrl_z(fix, name, text, mended):
    """An editor of DOS ends a file with Ctrl-Z; what is behind it is kept, and is no error."""
    result, found = fix(name, text)
    assert (result.return_value, found) == (0, mended)
    assert ".bak" in result.stdout or mended == text


@pytest.mark.parametrize(("suffix", "model"), [(".if1", "if1"), (".sms", "smartmotor"), (".181x", "1811")])
def test_nothing_behind_ctrl_z_is_checked_in_an_editor(suffix, model):
    assert diagnose_text("\r\n\x1a\0\x7f??", suffix, product(model)) == []


def test_a_link_is_followed(fix, tmp_path):
    (tmp_path / "there.if1").write_text("")
    (tmp_path / "here.if1").symlink_to("there.if1")
    fix("here.if1", "x1$\n")
    assert (tmp_path / "here.if1").is_symlink() and (tmp_path / "there.if1").read_text() == "X1$\n"


def test_a_file_that_cannot_be_replaced_is_unchanged(fix, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    raises(AxistwinError, "moves.if1 cannot be written: no space left on device", fix, "moves.if1", "x1$\n")
    assert (tmp_path / "moves.if1").read_text() == "x1$\n" and len(list(tmp_path.iterdir())) == 1


def test_a_file_without_fixes_is_not_written(fix, monkeypatch):
    monkeypatch.setattr(os, "replace", None)
    fix("moves.if1", "X1$\n")


def test_edits_are_applied_from_the_last_to_the_first():
    edits = [Edit(1, 2, 1, 2, "="), Edit(2, 1, 2, 3, "END"), Edit(1, 5, 2, 1, " ")]
    assert check_fix.apply("A100\r\nendx\r\n", edits) == "A=100 ENDdx\r\n"


PIECES = st.sampled_from(
    ["x", "X", "y", "100", "g", "$", ":", "@", "\n", " ", "a", "=", "A100", "endif", "IF a", "-----", "aw[0] 1", "C1",
     "RETURN", "F=32", "END", "'", "ES400", "GO_ON", "33"]
)  # fmt: skip


@pytest.mark.parametrize(("suffix", "model"), [(".if1", "if1"), (".sms", "smartmotor"), (".181x", "1811")])
@settings(max_examples=50)
@given(pieces=st.lists(PIECES, max_size=15))
def test_fixing_adds_no_errors_and_is_idempotent(suffix, model, pieces):
    made, text = product(model), "".join(pieces)
    before = diagnose_text(text, suffix, made)
    mended, done, left = check_fix.fix_text(text, lambda each: diagnose_text(each, suffix, made))
    errors = [sum(each.severity == "error" for each in found) for found in (before, left)]
    assert errors[1] <= errors[0] and (mended != text) == bool(done)
    assert check_fix.fix_text(mended, lambda each: diagnose_text(each, suffix, made))[:2] == (mended, [])


def test_a_file_name_in_capitals_is_accepted(fix, tmp_path):
    (tmp_path / "OLD.SMS").write_bytes(b"END C5 endif '\xe9\n")
    arguments = ["check", "OLD.SMS", "--fix"]
    CliRunner().invoke(axistwin, arguments, catch_exceptions=False, standalone_mode=False)
    assert (tmp_path / "OLD.SMS").read_bytes() == b"END C5 ENDIF '\xe9\n"
