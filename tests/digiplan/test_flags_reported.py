"""Each fault flag of K and F is reported by its name when it is set; triggers that wait for faults use this."""

import pytest

from .talking import ask, ready, write


def opened(pin):
    return lambda if1: if1.pins[pin].drive(False)


def in_odd_parity(if1):
    if1.serial.host.parity = "O"
    if1.serial.write(b"X")


def half_as_fast(if1):
    """Send a 0 byte at half the baud rate, which the receiver reads as a character without a stop bit."""
    if1.serial.host.baudrate //= 2
    if1.serial.write(b"\0")


RAISED = {
    "drive": (opened("x_fault"), b"16\r", b"0\r"),
    "emergency_stop": (opened("estop"), b"32\r", b"0\r"),
    "limit": (opened("limit_plus"), b"64\r", b"0\r"),
    "parity": (in_odd_parity, b"128\r", b"1\r"),
    "overrun": (lambda if1: write(if1, "  "), b"128\r", b"2\r"),
    "framing": (half_as_fast, b"128\r", b"4\r"),
    "data": (lambda if1: write(if1, "W"), b"128\r", b"8\r"),
    "range": (lambda if1: write(if1, "@99999"), b"128\r", b"16\r"),
}


@pytest.mark.parametrize("name", RAISED)
def test_a_trigger_waits_for_a_flag(bench, name):
    """Motion status, tables of K and F: exactly this bit is set, and its name was reported when it was set."""
    act, motion_status, communication_status = RAISED[name]
    if1 = ready(bench, "U64" if name == "parity" else "U61", strobe_ms=3 if name == "overrun" else 1)
    told = {
        flag: bench.faults.add("stuck", "if1.input1", level=True, when=f"if1 raises {flag}")
        for flag in RAISED
        if flag in (name, "data", "limit", "range")
    }
    bench.run(0.1)
    assert not any(fault.on for fault in told.values())
    host = if1.serial.host
    parity, baudrate = host.parity, host.baudrate
    act(if1)
    bench.run(0.1)
    assert [flag for flag, fault in told.items() if fault.on] == [name]
    host.parity, host.baudrate = parity, baudrate
    if name != "overrun":
        assert (ask(bench, if1, "K"), ask(bench, if1, "F")) == (motion_status, communication_status)
