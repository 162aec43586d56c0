"""Tests of the drivers' cores: answers arrive byte by byte; with AXISTWIN_ARRIVAL=both, also in one piece."""

import os

import pytest

from axistwin.drivers import SerialPort

ARRIVALS = ["byte by byte", "whole"] if os.environ.get("AXISTWIN_ARRIVAL") == "both" else ["byte by byte"]


@pytest.fixture(params=ARRIVALS)
def arrival(request, monkeypatch):
    if request.param != "whole":

        def one_byte(port, timeout):
            port._port.timeout = timeout
            return bytes(port._port.read(1))

        monkeypatch.setattr(SerialPort, "_read", one_byte)
    return request.param
