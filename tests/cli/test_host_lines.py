"""Each line that `--show-hosts` prints is executed against a served port, if its program is here."""

import shutil
import subprocess

import pytest
import serial

import axistwin
from axistwin.cli.serving import host_lines
from axistwin.links.urls import parse

EXCHANGE = {"if1": (b"(", b"U\r"), "smartmotor": (b"RP\r", b"0\r")}
KINDS = {
    "tcp": ["pyserial", "PyVISA", "asyn"], "rfc2217": ["pyserial", "PyVISA", "asyn"],
    "pty": ["pyserial", "PyVISA", "asyn"], "bus": ["by hand", "C"],
}  # fmt: skip
"""The kinds of lines that are printed for each kind of port; each needs a test below."""
C_HOST = '#include <stdio.h>\n#include "axistwin_bus.h"\nint main() { printf("%02x\\n", in(0x61)); return 0; }\n'
STATUS = "50"
"""The status byte of a board that is ready for a command."""


@pytest.fixture
def twin(request):
    model, scheme = request.param
    with axistwin.serve(model, speed="manual", scheme=None if scheme == "bus" else scheme) as twin:
        twin.advance(1.5)
        yield twin


def printed(twin, scheme):
    """Return the lines that are printed for the only port, by their kind."""
    ((name, url),) = twin.ports.items()
    port = parse(f"pty:{url}" if scheme == "pty" else f"{scheme}://{url.address}")
    lines = host_lines.bus(port) if scheme == "bus" else host_lines.lines(name, port, twin.bench.port(name).host.format)
    found: dict[str, list[str]] = {}
    for line in lines:
        found.setdefault(line[:10].strip() or next(reversed(found)), []).append(line[10:])
    return found


def served(*schemes, models=tuple(EXCHANGE)):
    cases = [(model, scheme) for model in models for scheme in schemes]
    return pytest.mark.parametrize(
        ("twin", "model", "scheme"), [(case, *case) for case in cases], ids=map("-".join, cases), indirect=["twin"]
    )


@pytest.mark.filterwarnings("ignore:set(Daemon|Name)")  # pyserial's RFC 2217
@served("tcp", "rfc2217", "pty")
def test_the_line_for_pyserial(twin, model, scheme):
    (code,) = printed(twin, scheme)["pyserial"]
    said, answer = EXCHANGE[model]
    with eval(code, {"serial": serial}) as host:  # opening takes no virtual time
        twin.call(host.write, said)
        assert twin.call(host.read, len(answer)) == answer


@served("tcp", "pty")
def test_the_line_for_pyvisa(twin, model, scheme):
    pyvisa = pytest.importorskip("pyvisa")
    pytest.importorskip("pyvisa_py")
    (code,) = printed(twin, scheme)["PyVISA"]
    said, answer = EXCHANGE[model]
    host = eval(code, {"pyvisa": pyvisa})
    try:
        twin.call(host.write_raw, said)
        assert twin.call(host.read) == answer.decode().rstrip("\r")
    finally:
        host.close()


@served("rfc2217", models=("if1",))
def test_a_port_that_pyvisa_cannot_open_says_what_can(twin, model, scheme):
    assert printed(twin, scheme)["PyVISA"] == ["not supported: use a TCP port or a pty"]


@served("bus", models=("1811",))
def test_the_line_by_hand(twin, model, scheme):
    if shutil.which("nc") is None:
        pytest.skip("nc is not here")
    command, _, typed = printed(twin, scheme)["by hand"][0].partition("then:")
    with subprocess.Popen(command, shell=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as hand:
        hand.stdin.write(f"{typed.strip()}\n")
        hand.stdin.flush()
        assert hand.stdout.readline() == f"{STATUS}\n"
        hand.terminate()


@served("bus", models=("1811",))
def test_the_request_by_hand(twin, model, scheme):
    """The request is typed as nc sends it, also where nc is not installed."""
    command, _, typed = printed(twin, scheme)["by hand"][0].partition("then:")
    program, host, port = command.split()
    with serial.serial_for_url(f"socket://{host}:{port}", timeout=300) as hand:
        hand.write(f"{typed.strip()}\n".encode())
        assert (program, hand.read_until(b"\n")) == ("nc", f"{STATUS}\n".encode())


@served("bus", models=("1811",))
def test_the_lines_for_c(twin, model, scheme, tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler is here")
    (tmp_path / "HOST.c").write_text(C_HOST)
    script = "\n".join(printed(twin, scheme)["C"])
    done = subprocess.run(script, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{STATUS}\n", "")


@served("tcp", "rfc2217", "pty", models=("if1",))
def test_the_lines_for_asyn(twin, model, scheme):
    pytest.skip("EPICS asyn is not here; test_synapps.py runs these lines where it is")


@served("tcp", "rfc2217", "pty", models=("if1",))
def test_every_kind_of_line_has_a_test(twin, model, scheme):
    assert list(printed(twin, scheme)) == KINDS[scheme]


@served("bus", models=("1811",))
def test_every_kind_of_line_for_a_bus_has_a_test(twin, model, scheme):
    assert list(printed(twin, scheme)) == KINDS[scheme]
