"""Program files as DOS, Windows and today's editors write them."""

import re

import pytest

from ..command import refused, run

TEXTS = {
    "p.if1": "; Vorschub für Maß, Öffner\nX100$\n", "p.181x": "; Größe\n83\n",
    "p.talk": "; model: if1\n; Rückhub\n+1.5\n> (\n< U\\r\n", "p.sms": "' Größe\nUCI UDI ZS\nEND\n",
}  # fmt: skip


@pytest.mark.parametrize("encoding", ["cp437", "cp850", "latin-1", "utf-8", "utf-8-sig"])
@pytest.mark.parametrize("name", TEXTS)
def test_comments_may_be_in_any_old_or_new_encoding(name, encoding, tmp_path):
    file = tmp_path / name
    file.write_bytes(f"{TEXTS[name]}\x1a".replace("\n", "\r\n").encode(encoding))
    assert run("check", file) == (0, "", f"axistwin: {file}: nothing wrong\n")


@pytest.mark.parametrize(("contents", "code"), [(b"X100$\x00", 1), ("X100$".encode("utf-16"), 1)])
def test_other_files_are_refused(contents, code, tmp_path):
    file = tmp_path / "p.if1"
    file.write_bytes(contents)
    assert run("check", file)[:2] == (
        code, f"{file}:1:1: error: the file is not text: expected UTF-8, Latin-1, or code page 437 or 850 [AX100]\n",
    )  # fmt: skip


@pytest.mark.parametrize(("keyboard", "encoding", "typed"), [
    ("germany", "cp850", "X100§900$"), ("germany", "latin-1", "X100§900$"), ("sweden", "cp437", "X100É900$"),
    ("france", "utf-8", "X100à900$"), ("norway", "latin-1", "X100É900¤")])  # fmt: skip
def test_the_first_comments_name_a_national_keyboard(keyboard, encoding, typed, tmp_path):
    file = tmp_path / "p.if1"
    file.write_bytes(f"; für\n; keyboard: {keyboard}\n{typed}\n".encode(encoding))
    assert run("check", file).code == 0 and "> X100@900$\\r" in run("run", "if1", file).out


def test_without_a_keyboard_its_characters_are_refused_with_a_hint(tmp_path):
    file = tmp_path / "p.if1"
    file.write_text("X100é900$\n", encoding="utf-8")
    assert run("check", file).out == (
        f"{file}:1:5: error: 'é' is not an ASCII character: for a national keyboard write, for example, "
        "; keyboard: germany in the first line [AX104]\n"
    )


@pytest.mark.parametrize("encoding", ["cp437", "latin-1", "utf-8"])
def test_characters_of_a_source_are_shown_as_typed_and_sent_as_a_question_mark(encoding, tmp_path):
    file = tmp_path / "p.sms"
    file.write_bytes('für=1\nPRINT("größer",#13)\nEND\n'.encode(encoding))
    assert run("check", file).out.startswith(f"{file}:1:1: error: unknown command für=1 ")
    assert "< gr??er\\r" in run("run", "smartmotor", file).out


def test_a_fix_keeps_the_encoding(tmp_path):
    file = tmp_path / "p.sms"
    file.write_bytes("A100 ' Größe\r\nEND\r\n".encode("cp850"))
    run("check", "--fix", file)
    assert file.read_bytes() == "A=100 ' Größe\r\nEND\r\n".encode("cp850")


NBSP = "\xa0"
TYPOGRAPHIC = {
    ("p.if1", "X−100$\nX100 ; “fine” – here\n"): ("X-100$\nX100 ; “fine” – here\n", ["1:2 −", ]),
    ("p.if1", f"X100{NBSP}@500$\n+{NBSP}1\n"): ("X100 @500$\n+ 1\n", ["1:5 U+00A0", "2:2 U+00A0"]),
    ("p.if1", "! x_fault ‑1\n"): ("! x_fault -1\n", ["1:11 ‑"]),
    ("p.181x", f"position{NBSP}–5\n"): ("position -5\n", ["1:9 U+00A0", "1:10 –"]),
    ("p.sms", "PRINT(“a=”,a,„ ok”) ' “fine”\n"): ('PRINT("a=",a," ok") \' “fine”\n', ["1:7 “"]),
    ("p.sms", "a=b−1 ’ it’s fine\n"): ("a=b-1 ' it’s fine\n", ["1:4 −", "1:7 ’"]),
    ("p.sms", f"UCI{NBSP}UDI{NBSP}ZS\n"): ("UCI UDI ZS\n", ["1:4 U+00A0"]),
    ("p.talk", f"; model: smartmotor\n; “fine”\n> P=−1{NBSP}\n+{NBSP}1\n"): (
        "; model: smartmotor\n; “fine”\n> P=-1 \n+ 1\n", ["3:5 −", "3:7 U+00A0", "4:2 U+00A0"],
    ),
    ("p.talk", "; model: if1\n; options: X.limits=[−5,5]\n"): (
        "; model: if1\n; options: X.limits=[-5,5]\n", ["2:22 −"],
    ),
}  # fmt: skip


WINDOWS = [(*case, "cp1252") for case in TYPOGRAPHIC if {"”", "–"} & {*case[1]} and "−" not in case[1]]


@pytest.mark.parametrize(("name", "text", "encoding"), [*((*case, "utf-8") for case in TYPOGRAPHIC), *WINDOWS])
def test_a_typographic_character_is_one_clear_error_that_is_fixed(name, text, encoding, tmp_path):
    fixed, errors = TYPOGRAPHIC[name, text]
    file = tmp_path / name
    file.write_bytes(text.encode(encoding))
    found = [line.removeprefix(f"{file}:") for line in run("check", file).out.splitlines() if "[AX106]" in line]
    assert [line.replace(": error:", "").partition(" is a ")[0] for line in found] == errors
    run("check", "--fix", file)
    assert file.read_bytes().decode(encoding) == fixed and "AX106" not in run("check", file).out


@pytest.mark.parametrize(("model", "name", "text"), [
    ("if1", "p.if1", "X−100$\n"), ("1811", "p.181x", "go_relative −100\n"), ("smartmotor", "p.talk", "> P=−1 \n"),
    ("1811", "p.talk", f"+{NBSP}1\n")])  # fmt: skip
def test_a_run_says_which_character_is_wrong(model, name, text, tmp_path):
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    code, err = refused("run", model, file)
    assert code == 1
    assert re.search(r":1:\d+: \S+ is a (typographic minus: write -|no-break space: write a blank)$", err.strip())


def test_a_stored_program_with_a_typographic_character_is_refused(tmp_path):
    file = tmp_path / "p.sms"
    file.write_text("a=b−1\nEND\n", encoding="utf-8")
    ran = run("run", "smartmotor", file)
    assert ran.code == 1 and f"! AX106 − is a typographic minus: write -  ({file}:1:4)" in ran.out


@pytest.mark.parametrize(("text", "said"), [
    ("model = “if1”", "2:9: error: not TOML: “ is a typographic quotation mark"),
    (f"model{NBSP}= 'if1'", "2:6: error: not TOML: U+00A0 is a no-break space: write a blank"),
    ("model = 'if1'\nX = {limits = [−5, 5]}", "3:16: error: not TOML: − is a typographic minus: write -")])  # fmt: skip
def test_a_typographic_character_in_a_scene_is_named(text, said, tmp_path):
    file = tmp_path / "s.toml"
    file.write_text(f"[[controller]]\n{text}\n", encoding="utf-8")
    assert run("check", file).out.startswith(f"{file}:{said}")
