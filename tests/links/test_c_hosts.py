"""C programs on the bus: those of the manual's appendix D, and all functions of `axistwin_bus.h`."""

import os
import re
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from axistwin.links.bus_hosts import C_FILES

from . import appendix_d
from .serving import HOST_TIMEOUT_S, Served

pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="there is no C compiler")
DOCS = (Path(__file__).parents[2] / "docs" / "bus.md").read_text(encoding="utf-8")
OLD_C = ("-std=gnu89", "-w")
STRICT = ("-std=c89", "-pedantic", "-Wall", "-Wextra", "-Werror")

MOVE = """
#include <stdio.h>

static char *board = (char *)0x60;
static char reply[16];

static int ask(command)
int command;
{
    char one = command;
    return sndcmd(board, &one, 1) || rcvcmd(board, reply, 16);
}

main()
{
    static char speed[] = {0x31, 0, 0, 0, 0, 0x61, 0xA8, 0, 3, 0xD0, 0x90};
    static char go[] = {0x33, 0, 0, 0x61, 0xA8};
    static char tell_end[] = {0xA4, 1};
    int i;

    if (sndcmd(board, speed, 11) || sndcmd(board, tell_end, 2) || sndcmd(board, go, 5))
        return 1;
    if (rcvcmd(board, reply, 1))
        return 2;
    printf("%02x\\n", reply[0] & 255);
    if (ask(0x83))
        return 3;
    for (i = 0; i < 16; i++)
        printf("%02x ", reply[i] & 255);
    return 0;
}
"""

WHOLE_HEADER = """
#include <stdio.h>
#include <string.h>
#include "axistwin_bus.h"

int main(void)
{
    static const unsigned char hello[] = {0x01, 0x2A};
    unsigned char message[300];

    while (!(in(0x0FFF) & 0x10))
        ;
    if (wait_interrupt(0))
        return 1;
    out_block(0x0FFE, hello, 2);
    out(0x0FFF, 0x50);
    if (!wait_interrupt(10000) || !interrupt_line())
        return 2;
    in_block(0x0FFE, message, 300);
    out(0x0FFF, 0x1C0 | 0x40);
    if (interrupt_line() || wait_interrupt(1))
        return 3;
    printf("%02x %02x", message[0], message[1]);
    return 0;
}
"""


@pytest.fixture
def bus(served):
    """An 1811 with the interrupts of a factory-new board and one jumper."""
    return served.open(served.add_board(), "bus://:0")


@pytest.fixture
def served():
    with Served() as served:
        yield served


def compiled(directory, options, **sources):
    """Return a program compiled from these sources and the package's C file."""
    files = []
    for name, text in sources.items():
        files.append(directory / f"{name}.c")
        files[-1].write_text(text)
    program = directory / "host"
    words = ["gcc", *options, f"-I{C_FILES}", *files, C_FILES / "axistwin_bus.c", "-o", program]
    made = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=HOST_TIMEOUT_S)
    assert made.returncode == 0, made.stderr
    return program


def translated(file, text, *options):
    """Return gcc's messages for a listing, compiled as C (by default, gcc takes .C for C++)."""
    file.write_text(text)
    words = ["gcc", "-std=gnu89", *options, "-x", "c", "-c", file, "-o", file.with_suffix(".o")]
    return subprocess.run(
        list(map(str, words)), capture_output=True, text=True, timeout=HOST_TIMEOUT_S, env={**os.environ, "LC_ALL": "C"}
    )


def run(program, bus):
    return subprocess.run(
        [str(program)], env={**os.environ, "AXISTWIN_BUS": bus}, capture_output=True, text=True, timeout=HOST_TIMEOUT_S
    )


@pytest.mark.skipif(not appendix_d.MANUAL.exists(), reason="the manual is not here")
def test_the_programs_of_appendix_d_drive_a_move(served, bus, tmp_path):
    """SNDCMD and RCVCMD of 1810U.C with I_FIFO and O_FIFO of FIFO.C, at base address 60h."""
    listings = appendix_d.programs()
    utility = appendix_d.FORWARD + listings["1810U.C"]
    program = compiled(tmp_path, (*OLD_C, appendix_d.COUNT), utility=utility, fifo=listings["FIFO.C"], move=MOVE)
    done = run(program, bus.address)
    assert (done.returncode, done.stderr) == (0, "")
    ended, position = done.stdout.splitlines()
    assert ended == "a4"
    assert bytes.fromhex(position) == bytes.fromhex("83 00 00 00 00 61 a8").ljust(16, b"\0")
    motor = served.bench["1811"].axes["motor"]
    assert (motor.position, len(motor.pulse_times())) == (25_000, 25_000)


@pytest.mark.skipif(not appendix_d.MANUAL.exists(), reason="the manual is not here")
@pytest.mark.parametrize(("name", "complaint", "front", "option"), [
    ("1810U.C", "conflicting types for .stat_wait", appendix_d.FORWARD, ()),
    ("FIFO.C", ".n. undeclared", "", (appendix_d.COUNT,))])  # fmt: skip
def test_appendix_d_needs_a_declaration_and_a_macro(tmp_path, name, complaint, front, option):
    """docs/bus.md names both, with this command."""
    listing = appendix_d.programs()[name]
    unchanged = translated(tmp_path / name, listing)
    assert unchanged.returncode != 0 and re.search(complaint, unchanged.stderr)
    assert (translated(tmp_path / name, front + listing, *option).returncode, DOCS.count(f"{appendix_d.COUNT} ")) == (
        0,
        1,
    )
    assert f"\n{appendix_d.FORWARD}" in DOCS


@pytest.fixture(scope="module")
def host(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("host"), STRICT, host=WHOLE_HEADER)


def test_the_whole_header(bus, host):
    done = run(host, bus.address)
    assert (done.returncode, done.stdout, done.stderr) == (0, "01 2a", "")


@pytest.mark.parametrize(("where", "words"), [
    ("", "set it to HOST:PORT"), ("nonsense", "set it to HOST:PORT"), ("127.0.0.1:1", "no answer")])  # fmt: skip
def test_a_bus_that_is_not_there_ends_the_program(host, where, words):
    done = run(host, where)
    assert done.returncode == 3 and words in done.stderr


def test_a_bus_that_another_host_has(bus, host):
    with socket.create_connection((bus.host, bus.port), timeout=HOST_TIMEOUT_S) as first:
        first.sendall(b"i\n")
        assert first.recv(10) == b"0\n"
        done = run(host, bus.address)
    assert done.returncode == 3 and "another host has the bus" in done.stderr


ANY = ""
TALK = (
    ("r 1", ANY),  # the power has just been switched on
    ("r 1", "50"),
    ("w 0 31 00 00 00 00 61 a8 00 03 d0 90", "ok"),
    ("  w   1  10 ", "ok"),
    ("w 0 33 00 00 61 a8", "ok"),
    ("w 1 10", "ok"),
    ("w 0 83\r", "ok"),
    ("w 1 10", "ok"),
    ("r 0 16", "83 00 00 00 00 61 a8 00 00 00 00 00 00 00 00 00"),
    ("w 1 80", "ok"),
    ("i", "0"),
    *((wrong, "error: ") for wrong in ("r 2", "r", "w 0", "w 0 100", "w 0 33 x", "r 0 257", "s 1", "x" * 1100)),
    ("w 0 " + "33 " * 257, "error: "),
    ("w 0 83", "ok"),
    ("w 1 10", "ok"),
    ("r 0 7", "83 00 00 00 00 61 a8"),
    ("w 1 80", "ok"),
    ("init", "ok"),
    ("r 1", ANY),
    ("w 0 83", "ok"),
    ("w 1 10", "ok"),
    ("r 0 7", "83 00 00 00 00 00 00"),  # a reset makes this position the origin
)
"""Requests and beginnings of the answers: those of docs/bus.md, and others."""


def test_the_bridge_answers_as_the_bus_socket_does(bus, tmp_path):
    """The bridge runs here with the package's `in` and `out`, which access the registers of a served board."""
    source = (C_FILES / "axistwin_bridge.c").read_text()
    program = compiled(tmp_path, (*STRICT, "-include", "axistwin_bus.h"), bridge=source)
    requests = "".join(f"{request}\n\n" for request, _ in TALK)
    done = subprocess.run(
        [str(program)], input=requests, env={**os.environ, "AXISTWIN_BUS": bus.address}, capture_output=True,
        text=True, timeout=HOST_TIMEOUT_S,
    )  # fmt: skip
    answers = done.stdout.splitlines()
    assert (done.returncode, done.stderr, len(answers)) == (0, "", len(TALK))
    for (request, expected), answer in zip(TALK, answers, strict=True):
        assert answer in (expected, expected or answer) or expected == "error: " == answer[:7], (request, answer)


def test_the_bridge_is_also_c_of_1978(tmp_path):
    source = (C_FILES / "axistwin_bridge.c").read_text()
    translated(tmp_path / "bridge.c", source, "-DBOARD=0x80")
    assert (tmp_path / "bridge.o").exists()
