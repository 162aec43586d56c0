"""Edges of the external encoder on pins A and B, for subscribers of these edges (base 12)."""

from fractions import Fraction
from math import floor

import pytest

from axistwin import Bench, tracing

LEVELS = ((True, True), (False, True), (False, False), (True, False))
"""Levels of A and B at counts 0 to 3."""
SAMPLE_NS = 245_760


@pytest.fixture
def bench():
    bench = Bench()
    bench.add("smartmotor", name="motor")
    bench.run(0.01)
    return bench


def observe(bench, pins="AB"):
    """Record time, pin and level of each edge.  Return the list and the unsubscribe functions."""
    edges = []
    pins = [bench["motor"].pins[name] for name in pins]
    ends = [pin.subscribe_edges(lambda pin: edges.append((bench.now, pin.name, pin.level))) for pin in pins]
    return edges, ends


def changes(counts):
    """Return the edges that result from the counts at the given times, beginning at count 0."""
    found, before = [], 0
    for time_ns, count in counts:
        for name, old, new in zip("AB", LEVELS[before % 4], LEVELS[count % 4], strict=True):
            if old is not new:
                found.append((time_ns, name, new))
        before = count
    return found


@pytest.mark.parametrize("counts", [10, -10])
@pytest.mark.parametrize("duration_ns", [1_000_003, 10, 7])
def test_edges_of_a_steady_run_come_in_their_nanosecond(bench, counts, duration_ns):
    edges, _ = observe(bench)
    began = bench.now
    bench["motor"].master.move(counts, duration_ns / 1e9)
    bench.run(0.01)
    times = [began - -n * duration_ns // 10 for n in range(1, 11)]
    expected = {time_ns: n * (1 if counts > 0 else -1) for n, time_ns in enumerate(times, 1)}  # the last of each time
    assert sorted(edges) == changes(expected.items())


@pytest.mark.parametrize("ratio", [1, -1, Fraction(3, 2), Fraction(-2, 7), 4, 0])
def test_edges_of_a_mounted_encoder_come_with_the_pulses_of_its_axis(bench, ratio):
    axis = bench.add("if1").axes["X"]
    bench["motor"].master.follow(axis, ratio)
    edges, _ = observe(bench)
    bench.run(1.5)
    for text in (b"(", b"U61\r", b"X 40 $\r", b"X - 25 $\r"):
        bench["if1"].serial.write(text)
        bench.run(1.0)
    directions = [1] * 40 + [-1] * 25
    pulses = axis.pulse_times()
    assert len(pulses) == len(directions)
    positions = [sum(directions[: n + 1]) for n in range(len(directions))]
    assert edges == changes((int(t), floor(p * ratio)) for t, p in zip(pulses, positions, strict=True))


def test_edges_of_an_encoder_on_a_servo_come_in_its_samples(bench):
    """The edges equal those found by reading the pins after every sample."""
    other = bench.add("smartmotor", name="other")
    bench["motor"].master.follow(other.axes["shaft"])
    edges, _ = observe(bench, "A")
    other.serial.write(b"UCI UDI ZS MV A=2000 V=20000 G ")
    read, before = [], True
    while bench.now < 0.3e9:
        bench.run(SAMPLE_NS / 1e9)
        level = bench["motor"].pins["A"].level
        if level is not before:
            read.append(level)
        before = level
    assert [level for _, _, level in edges] == read and len(read) > 50


def test_subscribers_change_nothing_and_may_leave(bench):
    def run(observed):
        bench = Bench()
        motor = bench.add("smartmotor", name="motor")
        edges, ends = observe(bench) if observed else ([], [])
        motor.master.move(1000, 0.1)
        motor.serial.write(b"UCI UDI ZS A=5000 MF4 ")
        bench.run(0.05)
        seen = len(edges)
        for end in ends:
            end()
        bench.run(0.1)
        motor.serial.write(b"RCTR RP RCLK ")
        bench.run(0.05)
        assert len(edges) == seen
        return motor.serial.read(), motor.axes["shaft"].position, seen

    *observed, seen = run(True)
    *unobserved, _ = run(False)
    assert observed == unobserved and seen == 500


def test_a_test_lead_ends_the_edges_until_its_release(bench):
    edges, _ = observe(bench, "A")
    motor = bench["motor"]
    motor.master.move(8, 0.008)
    bench.run(0.0015)
    motor.pins["A"].drive(True)
    bench.run(0.002)
    motor.pins["A"].drive(False)
    bench.run(0.002)
    motor.pins["A"].release()
    bench.run(0.01)
    assert [(round(time_ns / 1e5) / 10, level) for time_ns, _, level in edges] == [
        (11.0, False), (11.5, True), (13.5, False), (17.0, True)
    ]  # fmt: skip


def test_a_step_source_has_edges_on_b_only(bench):
    edges, _ = observe(bench)
    motor = bench["motor"]
    motor.serial.write(b"MS0 ")
    motor.master.move(0, 0)
    bench.run(0.05)
    del edges[:]
    for counts in (5, -5, 3):
        motor.master.move(counts, 0.01)
        bench.run(0.02)
    assert [(pin, level) for _, pin, level in edges] == [("B", True), ("B", False), ("B", True)]


@pytest.mark.parametrize(("when", "count"), [("motor.A rises", 3), ("motor.B falls", 2), ("motor.A changes", 1)])
def test_a_fault_begins_at_an_edge(bench, when, count):
    fault, began = bench.faults.add("stuck", "motor.E", level="high", when=when), []
    bench.faults.subscribe(lambda fault, what: began.append(bench["motor"].master.count))
    bench["motor"].master.move(8, 0.008)
    bench.run(0.01)
    assert fault.on and began == [count]


@pytest.mark.parametrize("moved_before", [True, False])
def test_a_trace_that_names_the_pin_has_its_edges(bench, tmp_path, moved_before):
    motor = bench["motor"]
    if moved_before:
        motor.master.move(4, 0)
    with tracing(bench, tmp_path / "t.csv", ("motor.A",)):
        motor.master.move(8, 0.008)
        bench.run(0.02)
    rows = [line for line in (tmp_path / "t.csv").read_text().splitlines() if line[:1].isdigit()]
    assert len(rows) == 5 and [row.rpartition(",")[2] for row in rows] == ["1", "0", "1", "0", "1"]
