"""The same inputs at the same virtual times give the same trace, to the byte, however a bench is run and read.

A session is a list of actions and their times.  It is played at once, in pieces with reads between them, at any speed
of a wall clock, with the SmartMotor's kernel in plain Python and compiled, and repeatedly.
"""

import itertools
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.controllers.smartmotor.kernel import jit, kernel
from axistwin.controllers.smartmotor.kernel.core import Engine
from axistwin.core.units import S
from axistwin.links.pacing import Pacer
from axistwin.records.traces.trace import tracing
from axistwin.sim.pins import connect

from .links.fake_loop import Loop

TICK = S // 64
"""What is done is done at multiples of this, which a float of seconds can hold exactly."""
EVERYTHING = ("*",)

Session = list[tuple[int, Callable[[Bench], object]]]


def says(name: str, text: str) -> Callable[[Bench], object]:
    return lambda bench: bench.port(name).write(text.encode())


def command(name: str, text: str) -> Callable[[Bench], object]:
    def write(bench: Bench) -> None:
        for byte in bytes.fromhex(text):
            bench[name].bus.write(0, byte)
        bench[name].bus.write(1, 0x10)

    return write


def takes_message(name: str) -> Callable[[Bench], object]:
    def take(bench: Bench) -> None:
        bus = bench[name].bus
        [bus.read(0) for _ in range(16)]
        bus.write(1, 0x80)

    return take


def drives(name: str, pin: str, level: bool | float) -> Callable[[Bench], object]:
    return lambda bench: bench[name].pins[pin].drive(level)


DIGIPLAN: Session = [
    (96, says("if1", "(")), (104, says("if1", "U61\r")), (176, says("if1", "X60@800Y-20S1$\r")),
    (180, says("if1", "E\r")), (184, drives("if1", "limit_plus", False)), (190, says("if1", "K\r")),
    (200, says("if1", ":Z9:P0,2:Z-R1:=2,1:$\r")), (230, lambda bench: bench["if1"].power_cycle()),
]  # fmt: skip
COMPUMOTOR: Session = [
    (72, command("1811", "31 00 00 00 00 03 E8 00 03 D0 90")), (74, command("1811", "33 00 00 00 64")),
    (78, command("1811", "83")), (80, takes_message("1811")), (81, drives("1811", "cw_limit", True)),
    (84, command("1811", "83")), (90, command("1811", "33 FF FF FF F0")), (96, lambda bench: bench["1811"].bus.init()),
]  # fmt: skip
PROGRAM = "C1 P=300 G TWAIT a=a+1 PRINT(a,#13) P=0 G WHILE Bt b=b+1 LOOP GOTO1 "
SMARTMOTOR: Session = [
    (40, says("motor", "UCI UDI ZS A=100 V=400000 MP O=0 P=500 G ")), (48, says("motor", "RP RPE ")),
    (52, drives("motor", "A", 2.5)), (54, lambda bench: bench["motor"].axes["shaft"].load(0.05)),
    (56, lambda bench: bench["motor"].axes["shaft"].encoder.displace(3)), (60, says("motor", "a=7 MV V=-100000 G ")),
    (70, says("motor", "X ")), (90, lambda bench: bench["motor"].power_cycle()), (110, says("motor", "RW c=RP ")),
]  # fmt: skip


def digiplan() -> Bench:
    bench = Bench()
    bench.add("if2", "if1", X={"limits": (-100, 100)}, Y={"motor": {"torque": [[0, 1.0], [500, 0.1]]}})
    return bench


def compumotor() -> Bench:
    bench = Bench()
    bench.add("1811", motor={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25_000}})
    return bench


def ideal_motor() -> Bench:
    bench = Bench()
    bench.add("smartmotor", "motor", shaft={"limits": (-2000, 2000)})
    return bench


def real_motor() -> Bench:
    bench = Bench()
    bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    return bench


def all_together() -> Bench:
    """An IF1's output starts the motor, whose brake line opens a limit of the 1811; two motors form a chain."""
    bench = real_motor()
    bench.add("if1")
    bench.add("1811")
    connect(bench["if1"].pins["output1"], bench["motor"].pins["G"], invert=True)
    connect(bench["motor"].pins["brake"], bench["1811"].pins["cw_limit"], delay_ns=1_234_567)
    bench.chain(bench.add("smartmotor", "left"), bench.add("smartmotor", "right"))
    return bench


CHAIN: Session = [(50, says("chain", "SADDR1 ECHO ")), (60, says("chain", "SLEEP WAKE RP RW "))]
SESSIONS: dict[str, tuple[Callable[[], Bench], Session, int]] = {
    "digiplan": (digiplan, DIGIPLAN, 300),
    "compumotor": (compumotor, COMPUMOTOR, 130),
    "ideal SmartMotor": (ideal_motor, SMARTMOTOR, 130),
    "SmartMotor": (real_motor, SMARTMOTOR, 130),
    "all together": (all_together, sorted((*DIGIPLAN, *COMPUMOTOR, *SMARTMOTOR, *CHAIN), key=lambda act: act[0]), 240),
}


def until(bench: Bench, tick: int) -> None:
    bench.clock.run_to(max(tick * TICK, bench.now))


def traced(family: str, run: Callable[[Bench, int], None] = until) -> bytes:
    build, session, end = SESSIONS[family]
    with TemporaryDirectory() as directory:
        path = Path(directory) / "a.csv"
        bench = build()
        with tracing(bench, path, EVERYTHING):
            for tick, act in session:
                run(bench, tick)
                assert bench.now == tick * TICK
                act(bench)
            run(bench, end)
        return path.read_bytes()


@cache
def reference(family: str) -> bytes:
    return traced(family)


def looker() -> Callable[[Bench], None]:
    """Return a function that reads one controller, another one at each call, and an eighth of its many registers."""
    count = itertools.count()

    def look(bench: Bench) -> None:
        controllers = list(bench.controllers.values())
        turn, which = divmod(next(count), len(controllers))
        controller = controllers[which]
        for axis in controller.axes.values():
            _ = axis.position, axis.velocity, axis.moving
        _ = [pin.level for pin in controller.pins.values()]
        _ = [register.read() for register in itertools.islice(controller.registers.values(), turn % 8, None, 8)]

    return look


FAMILIES = pytest.mark.parametrize("family", SESSIONS)


@FAMILIES
def test_it_moves_and_talks(family):
    """Check that the trace of a session contains motion and characters, so that comparing traces means something."""
    lines = reference(family).decode().splitlines()
    assert len([line for line in lines if not line.startswith(("#", "0,"))]) > 100
    assert any(".controller_says," in line for line in lines)


@FAMILIES
def test_again(family):
    assert traced(family) == reference(family)


@FAMILIES
@settings(max_examples=8, deadline=None, derandomize=True)
@given(data=st.data())
def test_in_pieces_and_looked_at(family, data):
    """A session cut at any nanosecond, with reads at each cut, gives the same trace."""
    pieces = data.draw(st.lists(st.tuples(st.integers(1, 40_000_000), st.booleans()), min_size=1, max_size=25))
    look = looker()

    def run(bench: Bench, tick: int) -> None:
        for length_ns, looks in pieces * 4:
            if looks:
                look(bench)
            bench.clock.run_to(min(bench.now + length_ns, tick * TICK))
        until(bench, tick)

    assert traced(family, run) == reference(family)


@FAMILIES
def test_stopped_at_conditions(family):
    """`run_until` checks its condition after each event and each sample; the trace is the same."""
    look = looker()

    def run(bench: Bench, tick: int) -> None:
        if bench.now < 80 * TICK:
            bench.run_until(lambda: look(bench), (tick * TICK - bench.now) / S / 8)
        until(bench, tick)

    assert traced(family, run) == reference(family)


class Clockwork(Loop):
    """A simulated wall clock that advances by a microsecond at each read."""

    def time(self):
        self.now_s += 1e-6
        return self.now_s


@FAMILIES
@pytest.mark.parametrize("speed", [0.5, 1, 64])
@pytest.mark.parametrize("late_s", [0, 0.02])
def test_at_any_pace(family, speed, late_s):
    """A wall clock wakes the bench at the planned times, or later on a busy machine; the trace is the same."""

    def run(bench: Bench, tick: int) -> None:
        loop, pacer = Clockwork(), Pacer(bench.clock, speed)
        paced_s = (tick * TICK - bench.now) / S / speed * 0.9
        if paced_s:
            pacer.start(loop)
        while loop.now_s < paced_s:
            loop.run_to(min(loop.now_s + 0.1, paced_s))
            loop.now_s += late_s
        pacer.stop()
        until(bench, tick)

    assert traced(family, run) == reference(family)


def needs_numba(*values):
    return pytest.param(*values, marks=pytest.mark.skipif(not jit.available(), reason="Numba is not installed"))


@pytest.mark.parametrize("family", [family for family in SESSIONS if family not in ("digiplan", "compumotor")])
@pytest.mark.parametrize("compiled_from", [None, needs_numba(0), needs_numba(40)])
def test_plain_and_compiled(family, compiled_from, monkeypatch):
    """The kernel in plain Python, compiled, and compiled from a later block on gives the same trace."""
    blocks = itertools.count()

    def chosen(_):
        return jit.best(kernel.advance) if compiled_from is not None and next(blocks) >= compiled_from else None

    monkeypatch.setattr(Engine, "_compiled", chosen)
    assert traced(family) == reference(family)
    assert compiled_from is None or next(blocks) > 100
