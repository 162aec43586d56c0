"""Program files as DOS, Windows and today's editors write them."""

import pytest

from ..command import run

TEXTS = {
    "p.if1": "; Vorschub für Maß, Öffner\nX100$\n",
    "p.181x": "; Größe\n83\n",
    "p.talk": "; model: if1\n; Rückhub\n+1.5\n> (\n< U\\r\n",
    "p.sms": "' Größe\nUCI UDI ZS\nEND\n",
}


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


@pytest.mark.parametrize(
    ("keyboard", "encoding", "typed"),
    [
        ("germany", "cp850", "X100§900$"),
        ("germany", "latin-1", "X100§900$"),
        ("sweden", "cp437", "X100É900$"),
        ("france", "utf-8", "X100à900$"),
        ("norway", "latin-1", "X100É900¤"),
    ],
)
def test_the_first_comments_name_a_national_keyboard(keyboard, encoding, typed, tmp_path):
    file = tmp_path / "p.if1"
    file.write_bytes(f"; für\n; keyboard: {keyboard}\n{typed}\n".encode(encoding))
    assert run("check", file).code == 0
    assert "> X100@900$\\r" in run("run", "if1", file).out


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
