"""State of an axis as EPICS shows it: the alarm, and the bits of MSTA."""

from dataclasses import dataclass

from axistwin.drivers.axis import Status

DIRECTION, DONE, PLUS, HOME_SWITCH, AT_HOME, PROBLEM, MOVING, SILENT, MINUS, HOMED = (
    1 << bit for bit in (0, 1, 2, 3, 7, 9, 10, 12, 13, 14)
)
"""Bits of MSTA."""


@dataclass(frozen=True)
class Alarm:
    """The alarm of an EPICS record: its status and its severity."""

    status: str = "NO_ALARM"
    severity: str = "NO_ALARM"


def alarm_of(status: Status, error: str, failure: str) -> tuple[Alarm, str]:
    """Return alarm and reason.  `error`: why the controller is silent; `failure`: why a motion has failed."""
    if error:
        return Alarm("COMM", "INVALID"), error
    if status.lost:
        return Alarm("UDF", "INVALID"), f"{status.lost}: home the axis, or set the position"
    if status.faults:
        return Alarm("STATE", "MAJOR"), "; ".join(map(str, status.faults))
    return (Alarm("STATE", "MAJOR"), failure) if failure else (Alarm(), "")


def status_bits(status: Status, *, busy: bool, forward: int, homed: bool) -> int:
    bits = {
        DIRECTION: forward, DONE: not busy, PLUS: status.limit_plus, HOME_SWITCH: status.at_home,
        AT_HOME: status.at_home, PROBLEM: status.faults, MOVING: status.moving, MINUS: status.limit_minus, HOMED: homed,
    }  # fmt: skip
    return sum(bit for bit, on in bits.items() if on)
