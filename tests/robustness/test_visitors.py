"""A small instance of `benchmarks/robustness/visitors.py`: clients come and go at each server."""

import asyncio
import importlib.util
import sys
from pathlib import Path

import pytest

if sys.platform != "linux":
    pytest.skip("what a process holds is read in /proc", allow_module_level=True)

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "robustness" / "visitors.py"
NEEDS = {"panel": "nicegui", "ca": "caproto", "pva": "p4p", "opcua": "asyncua", "lsp": "pygls"}


@pytest.fixture(scope="module")
def visitors():
    spec = importlib.util.spec_from_file_location("visitors", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules["visitors"] = module  # where dataclasses look up a module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["tcp", "shared", "rfc2217", "pty", "bus", "panel", "ca", "pva", "opcua", "lsp"])
@pytest.mark.timeout(240)
def test_nothing_is_left_of_twelve_clients(visitors, name, monkeypatch):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed")
    monkeypatch.setattr(visitors, "AT_ONCE", 2)
    assert asyncio.run(visitors.visits(name, 12, seed=1)) == []


def test_every_server_is_visited(visitors):
    assert [*visitors.SERVERS] == [
        mark for each in test_nothing_is_left_of_twelve_clients.pytestmark for mark in each.args[1]
    ]
