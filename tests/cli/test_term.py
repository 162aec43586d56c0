"""`axistwin term`: through a pipe, on a terminal, and with a controller at a port."""

import asyncio
import fcntl
import io
import os
import pty
import re
import select
import socket
import subprocess
import termios
import threading
from collections.abc import Callable
from functools import partial

import pytest

from axistwin.bench.programs.keyboards import to_codes, to_glyphs
from axistwin.cli.program import execute
from axistwin.ui.terminal.screen import Screen

from ..command import PATIENCE_S, PROGRAM, run, running
from ..links.serving import Served

AT_ONCE = ("--speed", "max")
term = partial(run, "term")


def after_initialisation(output: str) -> list[str]:
    lines = output.splitlines()
    assert lines[:3] == ["> (", "< U<CR>", "> U61<CR>"]
    return lines[3:]


def test_lines_through_a_pipe_are_dealt_with_one_after_the_other():
    with running("term", "if1", *AT_ONCE, stdin=subprocess.PIPE) as program:
        out, err = program.communicate("X1000$\nE\nN\n:axes\nK", timeout=PATIENCE_S)
    assert (program.returncode, err) == (0, "")
    assert after_initialisation(out) == [
        "> X1000$", "> E", "< C<CR>", "> N", "< 1000<CR>", "> :axes", "X  1000  at rest", "Y  0     at rest",
        "Z  0     at rest", "> K", "< 0<CR>",
    ]  # fmt: skip


def test_somebody_at_the_machine():
    lines = after_initialisation(
        term("if1", *AT_ONCE, typed=":drive input1 high\nI\n:pins\n:drive input1 release\nI\nS2$\n:pins\n").out
    )
    assert lines[:3] == ["> :drive input1 high", "> I", "< 192<CR>"]
    assert lines[4].split() == ["input1", "high", "driven"]
    assert lines[lines.index("> :drive input1 release") + 2] == "< 200<CR>"
    assert ["output2", "high"] in [line.split() for line in lines]


def test_a_run_goes_on_while_time_passes():
    lines = after_initialisation(term("if1", *AT_ONCE, typed="X@500G$\n:wait 2\n:axes\n#\nE\n").out)
    assert re.fullmatch(r"X  9\d\d  500 pulses/s", lines[3]) and lines[-1] == "< C<CR>"


def test_what_a_local_command_does_not_know():
    lines = after_initialisation(
        term("if1", typed=":what\n:drive nothing high\n:drive input1 up\n:speed no\n:wait x\n:quit\nE\n").out
    )
    assert lines[1] == "unknown command :what: expected a command of the terminal, e.g. :help"
    assert lines[3].startswith("unknown name 'nothing': expected one of input1")
    assert lines[5] == "invalid level 'up': expected one of high, on, low, off, release"
    assert lines[7] == "invalid speed 'no': expected `max` or a number up to 1000000, e.g. 1 for real time"
    assert lines[9] == "invalid time 'x': expected a number of seconds, e.g. :wait 0.5" and lines[10:] == ["> :quit"]


def test_a_national_keyboard():
    """Appendix 1: in the U.K. the key of the cancel code 23 hex shows £, and so does the terminal."""
    result = term("if1", *AT_ONCE, "--keyboard", "uk", typed=":X1000@10:$\n£\nE\n#\nE\n")
    assert result.err == ""
    assert [line for line in after_initialisation(result.out) if line[0] == "<"] == ["< C<CR>", "< C<CR>"]


@pytest.mark.parametrize(("keyboard", "typed", "sent"), [
    ("uk", "£", "#"), ("france", "à2000 °ç§^", "@2000 [\\]^"), ("germany", "§2000 ÄÜ", "@2000 []"),
    ("germany", "ä#$<>", "[#$<>"), ("sweden", "X1000É400¤", "X1000@400$"), ("norway", "æå ü", "[] ^"),
    ("us", "#$<>@[]^", "#$<>@[]^")])  # fmt: skip
def test_what_national_keyboards_send(keyboard, typed, sent):
    """Appendix 1: # $ @ [ ] ^ are sent by other keys; < and > are the same on all these keyboards."""
    assert to_codes(keyboard, typed) == sent
    assert to_codes(keyboard, to_glyphs(keyboard, "#$<>@[]^XYZ")) == "#$<>@[]^XYZ"


def test_a_national_keyboard_is_for_an_if1():
    result = term("1811", "--keyboard", "uk")
    assert result.code == 2 and "--keyboard uk is only for an IF1 or IF2" in result.err


def test_a_sequence_is_no_local_command():
    lines = after_initialisation(term("if1", *AT_ONCE, typed=":X100:Y:$\n:axes\n:x\n").out)
    assert [line.split()[1] for line in lines[2:5]] == ["100", "100", "0"]


def test_the_initialisation_can_be_left_to_the_user():
    result = term("if1", *AT_ONCE, "--no-init", "--end", "crlf", typed="E\n(\nV61\nE\n:help\n")
    assert result.out.splitlines()[:6] == ["> E", "> (", "< U<CR>", "> V61", "> E", "< C<CR><LF>"]
    assert ":drive input1 high" in result.out


def test_state_is_kept_from_one_session_to_the_next(tmp_path):
    assert term("if2", *AT_ONCE, "--state", tmp_path, typed=":X100:$\n[\n").code == 0
    lines = after_initialisation(term("if2", *AT_ONCE, "--state", tmp_path, typed="E\n:axes\n").out)
    assert lines[1] == "< [<CR>"
    assert lines[3].split()[:2] == ["X", "100"], "the stored sequence has run"


def test_a_controller_that_does_not_answer_is_told():
    assert "does not answer '(' at 19200" in term("if1", *AT_ONCE, "--line", "19200", typed=":quit\n").out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["if9"],
            "unknown model or port 'if9': expected if1, if2, 1810, 1811, smartmotor, or a port such as socket://127.0.0.1:5001",
        ),
        (["foo://x"], "cannot open foo://x (invalid URL, protocol 'foo' not known"),
        (["/dev/nowhere"], "cannot open /dev/nowhere ("),
        (["tcp://127.0.0.1:1", "--speed", "2"], "--speed is only for a virtual controller"),
        (["if1", "--speed", "fast"], "invalid speed 'fast': expected `max` or a number"),
        (["if1", "--line", "fast"], "invalid baud rate or character format 'fast': expected e.g. '9600 8N2'"),
    ],
)
def test_what_cannot_be_opened(arguments, message):
    result = term(*arguments)
    assert result.code == 2 and result.err.startswith(f"axistwin: {message}")
    assert result.err.count("\n") == 1 and "Errno" not in result.err


@pytest.fixture
def urls(tmp_path):
    """Yield the URLs of an IF1 on a free TCP port, an RFC 2217 port and a pty."""
    ports = "tcp://127.0.0.1:0", "rfc2217://127.0.0.1:0", f"pty:{tmp_path}/if1"
    with Served() as served:
        if1 = served.add(initialised=False)
        yield {url.scheme: str(url) for url in (served.open(if1, port) for port in ports)}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread
def test_a_controller_at_a_port(urls):
    first = term(urls["tcp"], typed="(\nU61\nX100$\nE\n:pins\n")
    assert first.out.splitlines() == [
        "> (",
        "< U<CR>",
        "> U61",
        "> X100$",
        "> E",
        "< C<CR>",
        "> :pins",
        (
            "this command needs a virtual controller, but the terminal is connected to a port: "
            "start axistwin term with a model, e.g. if1"
        ),
    ]
    for url in (urls["tcp"].replace("tcp", "socket"), urls["rfc2217"], urls["pty"], urls["pty"][4:]):
        assert term(url, typed="N\n").out.splitlines() == ["> N", "< 100<CR>"], url


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")  # of pyserial
def test_a_port_that_goes_away_is_told(monkeypatch, capsys):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def hang_up() -> None:
            connection, _ = server.accept()
            connection.recv(1)
            connection.close()

        threading.Thread(target=hang_up, daemon=True).start()
        address = "{}:{}".format(*server.getsockname())
        keys, typist = os.pipe()
        os.write(typist, b"E\n")
        with open(keys) as keyboard:
            monkeypatch.setattr("sys.stdin", keyboard)
            assert execute(["term", f"tcp://{address}"]) == 2
            os.close(typist)
        assert capsys.readouterr().err.startswith(f"axistwin: tcp://{address} was disconnected: ")


EDITING = "\x1b[?2004h"
"""What the line editor writes when it reads keys again; before, the terminal itself would take a Ctrl-D."""


class Person:
    def __init__(self, *arguments: str, **more: str) -> None:
        self.master, slave = pty.openpty()
        termios.tcsetwinsize(slave, (40, 120))
        words = [*PROGRAM, *arguments]
        self.program = subprocess.Popen(
            words,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            env={name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")} | more,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # so that Ctrl-C is an interrupt
        )
        os.close(slave)
        self.seen = ""

    def type(self, text: str) -> None:
        os.write(self.master, text.encode())

    def see(self, text: str) -> str:
        """Wait until `text` is on the screen.  Return and discard the output up to its end."""
        while text not in self.seen:
            ready, _, _ = select.select([self.master], [], [], PATIENCE_S)
            assert ready, f"{text!r} is not in {self.seen!r}"
            self.seen += os.read(self.master, 4096).decode()
        before, _, self.seen = self.seen.partition(text)
        return before + text

    def leave(self) -> int:
        code = self.program.wait(timeout=PATIENCE_S)
        os.close(self.master)
        return code


@pytest.fixture
def person():
    people: list[Person] = []

    def sit_down(*arguments: str, TERM: str = "dumb", **more: str) -> Person:  # noqa: N803
        people.append(Person(*arguments, TERM=TERM, **more))
        return people[-1]

    yield sit_down
    for one in people:
        one.program.kill()
        one.program.wait()


def test_a_person_at_a_terminal_who_interrupts(person: Callable[..., Person]):
    me = person("term", "if1", "--speed", "max", "--no-tutor")
    me.see("axistwin: Digiplan IF1 stepper motor interface.  :help lists the commands, :quit leaves.")
    me.see("< U\x1b[2m<CR>\x1b[0m")
    me.see("> ")
    me.type("E\n")
    me.see("< C\x1b[2m<CR>\x1b[0m\r\n> ")
    me.type("X250$\n:wait 2\n:axes\n")
    me.see("X  250  at rest")
    me.type("\x03")
    assert me.leave() == 130


def shown(*heard: bytes, person: bool = False) -> str:
    async def show() -> None:
        screen = Screen(out, person=person, colours=False)
        screen.prompt()
        for data in heard:
            screen.show_received(data)
        screen.close()

    out = io.StringIO()
    asyncio.run(show())
    return out.getvalue()


def test_control_characters_are_in_words_and_terminators_end_a_line():
    assert shown(b"U\r", b"C\r\nE", b"\r\n\x13\x11\x80") == "< U<CR>\n< C<CR><LF>\n< E<CR><LF>\n< <XOFF><XON><80>\n"


def test_a_prompt_makes_room_for_an_answer():
    assert shown(b"C\r", person=True) == "> \r\x1b[K< C<CR>\n"


@pytest.mark.slow
def test_a_person_at_a_line_editor(person: Callable[..., Person], tmp_path):
    me = person("term", "if1", "--speed", "max", TERM="xterm", PROMPT_TOOLKIT_NO_CPR="1", XDG_STATE_HOME=str(tmp_path))
    me.see("U61")
    me.type("x100\r")
    me.see("refused: unknown character 'x'")
    me.type("F\r")
    me.see("8 data fault")
    me.see(EDITING)
    me.type("\x04")
    assert me.leave() == 0
    assert "+x100" in (tmp_path / "axistwin" / "history-if1").read_text()


TUTORED = [
    ("if1", ":init\nx\nF\n:why\n", ["  8 data fault (A wrong message, or the buffer overflowed)"]),
    ("smartmotor", ":why\n:init\n:next\n", ["type  A=100", "both limit inputs are active (Bp, Bm)"]),
    ("1811", "go_relatve 5\ngo_relative 5\n:explain DP301\n", ["refused: ignored: 31", "no command 'go_relatve'"]),
]


@pytest.mark.parametrize(("model", "typed", "expected"), TUTORED)
def test_the_tutor(model, typed, expected):
    out = term(model, *AT_ONCE, "--no-init" if model == "if1" else "--tutor", "--tutor", typed=typed).out
    for line in expected:
        assert line in out
    assert "\x1b" not in out


def test_the_tutor_is_off_in_a_pipe_and_can_be_switched():
    assert "data fault" not in term("if1", *AT_ONCE, typed="x\nF\n").out
    assert "data fault" in term("if1", *AT_ONCE, typed="x\n:tutor on\nF\n").out
    assert "invalid value 'maybe' for the tutor" in term("if1", *AT_ONCE, typed=":tutor maybe\n").out


def test_a_program_is_loaded(tmp_path):
    (tmp_path / "a.sms").write_text("UCI UDI ZS\nA=100 V=100000 P=300 G\nEND\n")
    out = term("smartmotor", *AT_ONCE, typed=f":load {tmp_path}/a.sms\n:wait 1\n:axes\n:load\n").out
    assert "shaft  300" in out and "expected a file, e.g. :load home.sms" in out
