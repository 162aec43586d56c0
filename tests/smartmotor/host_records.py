"""Host mode's records as they lie on the wire (10.1), and a motor that has been sent some."""

from axistwin import Bench
from axistwin.bench import Controller

from .cam import SAMPLE_NS, say


def position(counts: int) -> str:
    """0xFA, four bytes, the most significant first, CR."""
    return "\xfa" + (counts & 0xFFFF_FFFF).to_bytes(4).decode("latin-1") + "\r"


def clock(samples: int) -> str:
    """0xFB, four bytes, the most significant first, CR."""
    return "\xfb" + (samples & 0xFFFF_FFFF).to_bytes(4).decode("latin-1") + "\r"


def points(*pairs: tuple[int, int]) -> str:
    """Positions, each with its clock."""
    return "".join(position(counts) + clock(samples) for counts, samples in pairs)


def begin(bench: Bench, motor: Controller, before: str, records: str) -> None:
    """Commands, MD, records, G; the samples that follow are those of the host mode's clock."""
    assert say(bench, motor, before + "MD ") == b""
    assert say(bench, motor, records) == b""
    assert say(bench, motor, "G ") == b""


def path(bench: Bench, motor: Controller, samples: int) -> list[int]:
    """The shaft's position at each of the samples to come."""
    found = []
    for _ in range(samples):
        bench.clock.run_to((bench.now // SAMPLE_NS + 1) * SAMPLE_NS)
        found.append(motor.axes["shaft"].position)
    return found
