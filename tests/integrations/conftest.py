"""A served IOC and its clients, each in a separate process; the clients share no code with the server."""

import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager, suppress

import pytest

SCENE = """
[[controller]]
model = "if1"
options = { self_test_s = 0.1, recalculation_s = 0.1 }
[controller.axes.X]
units = { per = 400, of = "mm" }
limits = [-4000, 12000]
[[controller]]
model = "1811"
name = "board"
[controller.axes.motor]
units = { per = 1000, of = "mm" }
[[controller]]
model = "smartmotor"
name = "motor"
"""
PATIENCE = {"timeout": 60.0}
"""Options of a driver at a controller that is faster than real time: its time-outs are by the wall clock."""
SLOW_COMPUTER = [word for name in ("if1", "board", "motor") for word in ("--option", f"{name}.timeout=60")]


def free_port():
    """Return a number such that this port and the eleventh and twelfth after it are free."""
    while True:
        with socket.create_server(("127.0.0.1", 0)) as first, socket.socket(type=socket.SOCK_DGRAM) as searches:
            number = first.getsockname()[1]
            with suppress(OSError, OverflowError):
                socket.create_server(("127.0.0.1", number + 11)).close()
                searches.bind(("127.0.0.1", number + 12))
                return number


@pytest.fixture(scope="session", autouse=True)
def repeater():
    """Hold the port of the CA repeater, so that no client starts one, which would outlive it; send no beacons."""
    with socket.socket(type=socket.SOCK_DGRAM) as held, pytest.MonkeyPatch.context() as patch:
        held.bind(("127.0.0.1", 0))
        patch.setenv("EPICS_CA_REPEATER_PORT", str(held.getsockname()[1]))
        patch.setenv("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "NO")
        patch.setenv("EPICS_CAS_BEACON_ADDR_LIST", "")
        yield


def environment(port):
    """Return the environment of a client that searches on this computer only."""
    return os.environ | {
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path), "EPICS_CA_ADDR_LIST": "127.0.0.1",
        "EPICS_CA_AUTO_ADDR_LIST": "NO", "EPICS_CA_SERVER_PORT": str(port), "EPICS_PVA_ADDR_LIST": "127.0.0.1",
        "EPICS_PVA_AUTO_ADDR_LIST": "NO", "EPICS_PVA_SERVER_PORT": str(port + 11),
        "EPICS_PVA_BROADCAST_PORT": str(port + 12),
    }  # fmt: skip


@contextmanager
def running(command, *words):
    """Run a command of axistwin until the block ends; yield the JSON object that it prints when it is ready."""
    process = subprocess.Popen(
        [sys.executable, "-m", "axistwin", command, *words, "--json"], stdout=subprocess.PIPE, text=True
    )
    try:
        line = process.stdout.readline()
        assert line, f"{command} ended with {process.wait()}"
        yield json.loads(line)
    finally:
        process.send_signal(signal.SIGTERM)
        code = process.wait()
        process.stdout.close()
    assert code == 0


def client(port, text):
    """Run a client's program; return the JSON that it prints in its last line."""
    words = [sys.executable, "-W", "ignore", "-c", text]
    done = subprocess.run(words, env=environment(port), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="session")
def scene_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("lab") / "lab.toml"
    path.write_text(SCENE)
    return path
