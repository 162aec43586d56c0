"""Tests of the drivers' cores: answers arrive byte by byte; with AXISTWIN_ARRIVAL=both, also in one piece."""

import os
from types import SimpleNamespace

import pytest

from .devices import Ports

ARRIVALS = ["byte by byte", "whole"] if os.environ.get("AXISTWIN_ARRIVAL") == "both" else ["byte by byte"]


@pytest.fixture(params=ARRIVALS)
def ports(request, monkeypatch):
    """Return a bench whose controllers the blocking drivers find at ports; a driver waits in virtual time."""
    made = Ports(whole=request.param == "whole")
    monkeypatch.setattr("axistwin.drivers.blocking.SerialPort", made.open)
    monkeypatch.setattr("axistwin.drivers.blocking.time", made)
    return made


@pytest.fixture(autouse=True, scope="module")
def sockets_that_close_at_once():
    """Do not wait 0.3 s after closing a socket, as pyserial does for slow servers."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("serial.urlhandler.protocol_socket.time", SimpleNamespace(sleep=lambda seconds: None))
        yield
