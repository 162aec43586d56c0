"""The registers of a board, as a host accesses them."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.registers import DATA, NOBODY_DRIVES, RegisterPort


@pytest.fixture
def port():
    port = RegisterPort(Clock())
    port.powered = True
    return port


def test_a_board_without_power_notices_nothing(port):
    port.powered = False
    port.on_init = lambda: pytest.fail("a board without power is initialised")
    port.write(DATA, 0x41)
    port.init()
    assert (port.read(DATA), port.input.contents) == (NOBODY_DRIVES, b"")


@pytest.mark.parametrize("access", [(DATA, 256), (DATA, -1), (2, 0), (DATA, True)])
def test_an_invalid_access_is_refused(port, access):
    with pytest.raises(UsageError, match=r"invalid (offset|value)"):
        port.write(*access)


def test_a_full_buffer_loses_bytes_and_an_empty_one_is_read_as_zero(port):
    for value in range(20):
        port.write(DATA, value)
    assert port.input.contents == bytes(range(16)) and port.read(DATA) == 0
