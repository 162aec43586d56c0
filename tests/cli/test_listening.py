"""The sockets on which each command listens are those of the table in `docs/ports.md`, and no others."""

import ipaddress
import os
import re
import socket
import sys
from pathlib import Path

import pytest

from ..command import running
from ..standin.command import StandInCommand

if sys.platform != "linux":
    pytest.skip("the sockets of a process are read in /proc", allow_module_level=True)

ADDRESS = re.compile(r"(127\.0\.0\.\d+):(\d+)")
SCENE = '[[controller]]\nmodel = "if1"\nname = "one"\n[[controller]]\nmodel = "1811"\nname = "two"\n'
NEEDS = {"--panel": "nicegui", "opcua": "asyncua", "ioc": "caproto", "--pva": "p4p", "lsp": "pygls"}
STAND_IN = """
[[controller]]
model = "if1"
name = "table"
ports = ["tcp://127.0.0.1:0"]
[stand-in]
horizon_ms = 1000
watchdog_ms = 1000
[[stand-in.board]]
name = "small"
port = "board"
[[stand-in.axis]]
axis = "table.X"
step = "P2"
direction = "P3"
enable = "!P4"
travel = [-10, 10]
"""
LISTENS, UNCONNECTED = "0A", "07"
"""States of TCP and UDP sockets that anybody can send to."""


def listening(process: int) -> set[tuple[str, str, int]]:
    """Return the protocol, the address and the port of each socket on which a process and its children listen."""
    own, found = inodes(process), set()
    for name, wanted in (("tcp", LISTENS), ("tcp6", LISTENS), ("udp", UNCONNECTED), ("udp6", UNCONNECTED)):
        for line in Path(f"/proc/{process}/net/{name}").read_text().splitlines()[1:]:
            _, local, _, state, *_, inode = line.split()[:10]
            if state == wanted and inode in own:
                digits, _, port = local.partition(":")
                words = [bytes.fromhex(digits[at : at + 8])[::-1] for at in range(0, len(digits), 8)]
                found.add((name, str(ipaddress.ip_address(b"".join(words))), int(port, 16)))
    return found


def inodes(process: int) -> set[str]:
    """Return the inodes of all sockets of a process and its children."""
    root = Path(f"/proc/{process}")
    links = [os.readlink(link) for link in (root / "fd").iterdir()]
    children = " ".join((task / "children").read_text() for task in (root / "task").iterdir()).split()
    return {link[8:-1] for link in links if link.startswith("socket:[")}.union(*map(inodes, map(int, children)))


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as made:
        return made.getsockname()[1] % 20_000 + 30_000


@pytest.mark.slow
@pytest.mark.parametrize("words", [
    ("serve", "if1"), ("serve", "if1", "--tcp", "127.0.0.2:0"), ("serve", "smartmotor", "--tcp", ":0", "--rs485", ":0"),
    ("serve", "1811", "--bus", ":0"), ("serve", "if1", "--rfc2217", ":0"), ("serve", "if1", "--pty", "LINK"),
    ("serve", "if1", "--tcp", ":0", "--panel", "0"),
    ("record", "--serial", "socket://CONTROLLER", "--tcp", "127.0.0.1:0", "-o", "FILE"),
    ("opcua", "SCENE", "--port", "PORT"), ("ioc", "SCENE", "--prefix", "L:", "--json", "--port", "PORT"),
    ("ioc", "SCENE", "--prefix", "L:", "--json", "--port", "PORT", "--pva"), ("term", "if1"),
    ("lsp",)], ids=" ".join)  # fmt: skip
def test_a_command_listens_where_the_documentation_says(words, tmp_path):
    for word, module in NEEDS.items():
        if word in words:
            pytest.importorskip(module, reason=f"{module} is not installed")
    (tmp_path / "scene.toml").write_text(SCENE)
    with socket.create_server(("127.0.0.1", 0)) as controller:
        given = {
            "PORT": free_port(), "SCENE": tmp_path / "scene.toml", "LINK": tmp_path / "if1",
            "FILE": tmp_path / "a.talk", "socket://CONTROLLER": f"socket://127.0.0.1:{controller.getsockname()[1]}",
        }  # fmt: skip
        with running(*(given.get(word, word) for word in words), stdin=-1) as program:
            if words == ("lsp",):
                program.stdin.write(START)
                program.stdin.flush()
            lines = "".join(program.stdout.readline() for _ in range(2 if {"--panel", "--rs485"} & {*words} else 1))
            assert lines, program.stderr.read()
            found = listening(program.pid)
    said = {("tcp", host, int(port)) for host, port in ADDRESS.findall(lines)}
    assert not said if words[0] in ("lsp", "term") or "--pty" in words else said
    if words[0] == "ioc":
        number = given["PORT"]
        said.add(("udp", "127.0.0.1", number))
        if "--pva" in words:
            said |= {("tcp", "127.0.0.1", number + 11), ("udp", "0.0.0.0", number + 12)}
            sending = [each for each in found - said if each[:2] == ("udp", "0.0.0.0")]
            assert len(sending) == 1  # p4p sends its beacons from there
            said.update(sending)
    assert found == said


BODY = '{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"processId":null,"rootUri":null,"capabilities":{}}}'
START = f"Content-Length: {len(BODY)}\r\n\r\n{BODY}"


@pytest.mark.slow
def test_a_stand_in_listens_on_its_ports_and_its_page(tmp_path):
    run = StandInCommand(tmp_path, STAND_IN, "--panel", "0")
    try:
        lines = run.first + run.program.stdout.readline()
        found = listening(run.program.pid)
    finally:
        run.close()
    said = {("tcp", host, int(port)) for host, port in ADDRESS.findall(lines)}
    assert found == said and len(said) == 2
