"""Each fault flag of K and F is reported by its name when it is set; triggers that wait for faults use this."""

import pytest

from .talking import play, ready

RAISED = {
    "drive": ("x_fault low", 16, 0),
    "emergency_stop": ("estop low", 32, 0),
    "limit": ("limit_plus low", 64, 0),
    "parity": ("host 8O2; sends X", 128, 1),
    "overrun": ("sends <SP><SP>", 128, 2),
    "framing": ("host 4800; sends <00>", 128, 4),  # at half the baud rate, a character without a stop bit
    "data": ("W", 128, 8),
    "range": ("@99999", 128, 16),
}


@pytest.mark.parametrize("name", RAISED)
def test_a_trigger_waits_for_a_flag(bench, name):
    """Motion status, tables of K and F: exactly this bit is set, and its name was reported when it was set."""
    script, motion_status, communication_status = RAISED[name]
    if1 = ready(bench, "U64" if name == "parity" else "U61", strobe_ms=3 if name == "overrun" else 1)
    told = {
        flag: bench.faults.add("stuck", "if1.input1", level=True, when=f"if1 raises {flag}")
        for flag in RAISED
        if flag in (name, "data", "limit", "range")
    }
    bench.run(0.1)
    assert not any(fault.on for fault in told.values())
    sent_in = if1.serial.host.format
    play(bench, if1, f"{script}; 0.1 s")
    assert [flag for flag, fault in told.items() if fault.on] == [name]
    if1.serial.host.format = sent_in
    if name != "overrun":
        play(bench, if1, f"K: {motion_status}; F: {communication_status}")
