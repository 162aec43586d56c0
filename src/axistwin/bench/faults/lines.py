"""Faults on serial lines: characters, breaks, baud rates, handshake lines, cables."""

from collections.abc import Iterable

from axistwin.bench.faults.places import Spot
from axistwin.bench.faults.table import Case, Mend, all_of, ended
from axistwin.core.errors import UsageError
from axistwin.core.units import to_ns
from axistwin.sim import disturbance
from axistwin.sim.disturbance import Disturbance, Effect
from axistwin.sim.frames import FASTEST_BAUD
from axistwin.sim.serial import Line
from axistwin.sim.serial_port import SerialPort

WAYS = "to", "from", "both"


def lose(case: Case) -> Mend:
    """Fault: characters are lost."""
    return _some(case, disturbance.lose)


def double(case: Case) -> Mend:
    """Fault: characters are received twice."""
    return _some(case, disturbance.double)


def flip(case: Case) -> Mend:
    """Fault: data bits are inverted.  `mask`: the bits; 0: one random bit of each character."""
    mask = case.values["mask"]
    if mask:
        return _some(case, disturbance.flip(mask))
    chance = case.luck("the inverted bit")
    return _some(case, lambda passage: disturbance.flip(1 << chance.below(8))(passage))


def late(case: Case) -> Mend:
    """Fault: all characters arrive later, in the same order."""
    delay, jitter = to_ns(case.values["seconds"]), to_ns(case.values["jitter"])
    if not jitter:
        return _all(case, disturbance.delay(lambda: delay))
    chance = case.luck("the jitter")
    return _all(case, disturbance.delay(lambda: delay + chance.below(jitter + 1)))


def drift(case: Case) -> Mend:
    """Fault: the sender's clock is too fast or too slow."""
    faster = 1 + case.values["percent"] / 100
    return _all(case, disturbance.at_rate(lambda baudrate: min(max(1, round(baudrate * faster)), FASTEST_BAUD)))


def baud(case: Case) -> Mend:
    """Fault: the host uses a wrong baud rate."""
    host = _port(case).host
    before, host.baudrate = host.baudrate, case.values["baudrate"]

    def mend() -> None:
        # Restore the old baud rate, unless the host has set another baud rate since the fault began.
        if host.baudrate == case.values["baudrate"]:
            host.baudrate = before

    return mend


def line_break(case: Case) -> Mend:
    """Fault: the line stays at the space level (logic 0) for some time, even while characters are sent."""
    duration_ns = to_ns(case.values["seconds"])
    for line in _lines(case):
        line.short(duration_ns)
    return ended


def cut(case: Case) -> Mend:
    """Fault: the transmit wire, the receive wire or both are open; with both, the control lines are off."""
    mends = [line.sever() for line in _lines(case)]
    if case.values["way"] == "both":
        mends += [pin.hold(False) for pin in _port(case).control_lines.values()]
    return all_of(mends)


def handshake(case: Case) -> Mend:
    """Fault: hold one control line at a level."""
    return _port(case).control_lines[case.values["line"]].hold(case.values["level"])


def hang_up(case: Case) -> Mend:
    """Fault: the port disconnects its client, and is gone."""
    return _port(case).hung_up.hold(True)


def check_handshake(spot: Spot) -> None:
    """Raise UsageError if the serial port has no control lines (DTR, RTS, DSR and CTS)."""
    if spot.port is None or not spot.port.handshake:
        raise UsageError(f"{spot.name} has no control lines: expected a serial port of an IF1 or IF2, e.g. if1.serial")


def _some(case: Case, effect: Effect) -> Mend:
    probability, count = case.values["probability"], case.values["count"]
    if count is None and probability == 1 and not case.lasts:
        count = 1
    strikes = disturbance.always
    if probability < 1:
        chance = case.luck(f"probability={probability:g}")
        strikes = lambda: chance.unit() < probability  # noqa: E731
    return _disturb(case, [Disturbance(effect, count, strikes) for _ in _lines(case)])


def _all(case: Case, effect: Effect) -> Mend:
    return _disturb(case, [Disturbance(effect) for _ in _lines(case)])


def _disturb(case: Case, disturbances: list[Disturbance]) -> Mend:
    for one in disturbances:
        one.on_over = lambda: case.over() if all(other.over for other in disturbances) else None
    return all_of([line.disturb(one) for line, one in zip(_lines(case), disturbances, strict=True)])


def _lines(case: Case) -> Iterable[Line]:
    port, way = _port(case), case.values["way"]
    return [
        line for line, ways in ((port.to_device, ("to", "both")), (port.from_device, ("from", "both"))) if way in ways
    ]


def _port(case: Case) -> SerialPort:
    assert case.spot.port is not None, "a line was found"
    return case.spot.port
