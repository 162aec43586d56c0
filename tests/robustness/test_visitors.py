"""A small instance of `benchmarks/robustness/visitors.py`: clients come and go at each server."""

import subprocess
import sys

import pytest

from ..campaigns import ROBUSTNESS, campaign

if sys.platform != "linux":
    pytest.skip("what a process holds is read in /proc", allow_module_level=True)

SERVERS = ("tcp", "shared", "rfc2217", "pty", "bus", "panel", "ca", "pva", "opcua", "stop_page", "lsp")
NEEDS = {"panel": "nicegui", "ca": "caproto", "pva": "p4p", "opcua": "asyncua", "lsp": "pygls"}


@pytest.mark.slow
@pytest.mark.parametrize("name", SERVERS)
def test_nothing_is_left_of_twelve_clients(name):
    """Run the script in a process of its own, because it changes libraries, and a process can have only one panel."""
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed")
    command = [sys.executable, ROBUSTNESS / "visitors.py", "--clients", "12", "--only", name]
    ended = subprocess.run(command, capture_output=True, text=True)
    found = ended.stdout, ended.returncode
    assert found == (f"{name}: 12 clients, nothing is left\nheld (seed 1)\n", 0), ended.stderr


def test_every_server_is_visited():
    assert tuple(campaign("visitors").SERVERS) == SERVERS
