"""The fault `hang_up`: a port is gone, and comes back."""

import os
import sys
from contextlib import suppress

import pytest
import serial

from .serving import HOST_TIMEOUT_S, Served, ask, dial, receive


def hang_up(served):
    return served.do(lambda: act(served, lambda: served.bench.faults.add("hang_up", "if1")))


def mend(served):
    served.do(lambda: act(served, lambda: served.bench.faults.mend("hang_up")))


def act(served, action):
    result = action()
    served.server.pacer.work()
    return result


@pytest.mark.parametrize("share", [False, True], ids=["alone", "shared"])
def test_a_tcp_port_hangs_up_and_comes_back(share):
    with Served(share=share) as served:
        url = served.open(served.add())
        with dial(url) as host:
            assert ask(host) == b"C\r"
            hang_up(served)
            with suppress(ConnectionResetError):
                assert receive(host, 1) == b""
        with dial(url) as refused, suppress(ConnectionResetError):
            assert receive(refused, 1) == b""
        mend(served)
        with dial(url) as host:
            assert ask(host) == b"C\r"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread
def test_an_rfc2217_port_hangs_up_and_comes_back(served):
    url = served.open(served.add(), "rfc2217://127.0.0.1:0")
    host = serial.serial_for_url(f"rfc2217://{url.address}", timeout=HOST_TIMEOUT_S)
    host.write(b"E\r")
    assert host.read(2) == b"C\r"
    hang_up(served)
    with suppress(serial.SerialException):  # depends on what pyserial's reader thread notices first
        assert host.read(1) == b""
    host.close()
    with dial(url) as refused, suppress(ConnectionResetError):
        assert receive(refused, 1) == b""
    mend(served)
    with serial.serial_for_url(f"rfc2217://{url.address}", timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"


@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_a_pty_is_gone_with_its_link_and_comes_back(served, tmp_path):
    link = tmp_path / "if1"
    served.open(served.add(), f"pty:{link}")
    with serial.Serial(str(link), timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"
        hang_up(served)
        served.do(lambda: None)
        with pytest.raises(serial.SerialException):
            host.read(1)
    assert not os.path.lexists(link)
    mend(served)
    served.do(lambda: None)
    with serial.Serial(str(link), timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"


def test_a_port_that_is_gone_closes_with_its_server(served, tmp_path):
    if1 = served.add()
    served.open(if1)
    if sys.platform == "linux":
        served.open(if1, f"pty:{tmp_path}/if1")
    hang_up(served)
