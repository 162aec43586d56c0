"""A trace in memory has the same contents as a trace in a file, but a limited size."""

import pytest

from axistwin import Bench, tracing
from axistwin.records.traces import memory as module
from axistwin.records.traces.memory import tracing_in_memory
from axistwin.records.traces.reading import read


def test_it_has_the_same_signals_and_changes_as_a_file(tmp_path):
    bench = Bench()
    if1, motor = bench.add("if1"), bench.add("smartmotor", shaft={"motor": "frame23"})
    with tracing(bench, tmp_path / "a.csv"), tracing_in_memory(bench) as memory:
        bench.run(1.5)
        if1.serial.write(b"(")
        motor.serial.write(b"UCI UDI ZS A=200 V=100000 P=500 G RP\r")
        bench.run(0.1)
        if1.serial.write(b"U61\r")
        bench.run(1.2)
        if1.serial.write(b"X100 Y-$\r")
        motor.pins["A"].drive(2.5)
        bench.run(1.0)
    found, expected = memory.trace(), read(tmp_path / "a.csv")
    assert (found.begin_ns, found.end_ns, found.about) == (expected.begin_ns, expected.end_ns, expected.about)
    assert found.tracks == expected.tracks


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(module, "POINTS", 1 << 8)
    monkeypatch.setattr("axistwin.records.traces.trace.CHUNK", 1 << 8)
    return 1 << 8


def test_a_long_servo_move_is_reduced_and_keeps_its_largest_error(few):
    bench = Bench()
    motor = bench.add("smartmotor", shaft={"motor": "frame23"})
    with tracing_in_memory(bench) as memory:
        motor.serial.write(b"UCI UDI ZS A=200 V=100000 P=3000 G\r")
        bench.run(0.2)
        motor.axes["shaft"].encoder.displace(77)
        bench.run(1.5)
    position, commanded = (memory.trace().tracks[f"smartmotor.shaft.{name}"] for name in ("position", "commanded"))
    assert len(position) <= 3 * few and len(commanded) <= 3 * few
    assert (position.values[0], position.values[-1]) == (0, motor.axes["shaft"].position)
    places = dict(zip(position.times, position.values, strict=True))
    errors = [places[t] - value for t, value in zip(commanded.times, commanded.values, strict=True) if t in places]
    assert max(errors) > 70 and list(position.times) == sorted(position.times)


def test_a_long_run_keeps_extremes_of_numbers_and_the_latest_texts(few):
    bench = Bench()
    if1 = bench.add("if1")
    with tracing_in_memory(bench) as memory:
        for message, seconds in ((b"", 1.5), (b"(", 0.1), (b"U61\r", 1.2), (b"X2000@4000$\r", 2.0), (b"X-$\r", 2.0)):
            if1.serial.write(message)
            bench.run(seconds)
        for _ in range(200):
            if1.serial.write(b"E\r")
            bench.run(0.02)
    tracks = memory.trace().tracks
    pulses = tracks["if1.X.pulses"]
    assert len(pulses) <= 3 * few and (min(pulses.values), max(pulses.values), pulses.values[-1]) == (0, 2000, 0)
    said = tracks["if1.controller_says"]
    assert len(said) <= 3 * few and said.values[-1] in ("", r"C\r") and said.times[0] > 1.5e9
