"""The picture: exact curves, labels and lanes."""

import errno
import os
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest

from axistwin import Bench
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.units import S
from axistwin.records.plots.chart import Curve, Fault
from axistwin.records.plots.picture import save
from axistwin.records.plots.trace_chart import of_trace
from axistwin.records.traces.memory import tracing_in_memory
from axistwin.records.traces.reading import Trace


def session(*messages: str, **options) -> Trace:
    bench = Bench()
    if1 = bench.add("if1", **options)
    with tracing_in_memory(bench) as memory:
        bench.run(1.5)
        for message in ("(", "U61\r", *messages):
            if1.serial.write(message.encode())
            bench.run(2.0)
    return memory.trace()


def draw(trace: Trace, path, *signals: str, title: str = "") -> None:
    save(of_trace(trace, signals or ("*",), title=title), path)


def curves(trace: Trace) -> dict[str, Curve]:
    """Return the curves of the whole run, by the first words of their labels."""
    chart = of_trace(trace, from_ns=0, to_ns=20 * S)
    return {panel.label.partition("\n")[0].replace("  ", " "): panel.lines[0].curve for panel in chart.panels}


@pytest.fixture(scope="module")
def trace() -> Trace:
    return session("S1$\r", "X100@1000Y-$\r", "P2,50$\r", "X-50$\r", "E\r")


def texts(svg) -> list[str]:
    return [element.text or "" for element in ET.parse(svg).iter("{http://www.w3.org/2000/svg}text")]


def test_svg_has_axes_levels_and_words_and_is_the_same_each_time(tmp_path, trace):
    for name in ("a.svg", "b.svg"):
        draw(trace, tmp_path / name, title="a title")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    found = texts(tmp_path / "a.svg")
    assert {"a title", "seconds", "X  velocity", "X  position", "Y  velocity", "output1", "output2"} <= set(found)
    assert r"> X100@1000Y-$\r" in found and not any(text.startswith("Z") for text in found)
    assert "output3" not in found


def test_faults_are_marked_from_beginning_to_end(tmp_path):
    bench = Bench()
    if1 = bench.add("if1", X={"encoder": {}})
    bench.faults.add("stuck", "if1.input3", level="high", name="since_before")
    bench.faults.add("jam", "if1.X", when="if1.X passes 50", duration=0.1)
    bench.faults.add("push", "if1.X", counts=3, when="jam begins")
    bench.faults.add("load", "if1.X", torque=0.1, at=100)
    with tracing_in_memory(bench) as memory:
        for message, seconds in (("", 1.5), ("(", 0.1), ("U61\r", 1.2), ("X100@1000$\r", 1.0)):
            if1.serial.write(message.encode())
            bench.run(seconds)
    jam, push = bench.faults["jam"], bench.faults["push"]
    assert of_trace(memory.trace()).faults == [
        Fault("since_before", 0, None),
        Fault("jam", jam.began_ns, jam.began_ns + S // 10),
        Fault("push", push.began_ns, push.began_ns),
    ]
    draw(memory.trace(), tmp_path / "a.svg")
    assert {"since_before", "jam", "push"} <= set(texts(tmp_path / "a.svg")) and "load" not in texts(tmp_path / "a.svg")


def test_png(tmp_path, trace):
    draw(trace, tmp_path / "a.png", "if1.output1")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("messages", [(), ("X@1000G$\r",)])
def test_nothing_moved_or_it_still_moves(tmp_path, messages):
    draw(session(*messages), tmp_path / "a.svg")
    assert ("X  velocity" in texts(tmp_path / "a.svg")) is bool(messages)


def test_velocity_is_the_profile_itself(trace):
    curve = curves(trace)["X velocity"]
    levels = [400.0, 500.0, 600.0, 700.0, 800.0, 900.0]
    assert curve.values[:15] == [0, *levels, 1000.0, *reversed(levels), 0]
    gaps = [round((after - before) * 1000, 6) for before, after in pairwise(curve.times[1:15])]
    assert gaps == [10.0] * 6 + [22.0] + [10.0] * 6  # 100 - 2 * 39 pulses at 1000 pulses/s


def test_a_motion_that_follows_at_once_has_no_rest_before_it():
    values = curves(session(":X10@400:X10@500:$\r"))["X velocity"].values
    assert values[0] == values[-1] == values[-2] == 0 and 500.0 in values
    assert 0 not in values[1:-2]


def test_position_ends_where_the_axis_is(trace):
    for name in ("X", "Y"):
        curve = curves(trace)[f"{name} position"]
        assert curve.values[0] == 0 and curve.values[-1] == trace.tracks[f"if1.{name}.pulses"].values[-1] != 0
        assert curve.times == sorted(curve.times)


def test_a_motion_that_has_not_ended_continues_to_the_edge():
    running = session("X@1000G$\r")
    found = curves(running)
    assert found["X velocity"].values[-2:] == [1000.0, 1000.0]
    assert found["X position"].values[-1] == running.tracks["if1.X.pulses"].values[-1] > 1000


def test_a_long_curve_is_thinned_but_keeps_its_extremes():
    curve = Curve([float(n) for n in range(100_000)], [0.0] * 100_000)
    curve.values[54_321] = 9.0
    curve.values[12_345] = -7.0
    thin = curve.thinned(1000)
    assert len(thin.times) <= 1010 and (max(thin.values), min(thin.values)) == (9.0, -7.0)
    assert (thin.times[0], thin.times[-1]) == (0.0, 99_999.0) and thin.times == sorted(thin.times)


@pytest.mark.slow
def test_many_moves_make_no_large_picture(tmp_path):
    draw(session(":X10@400:X-:S1:R1:=0,1:$\r", *[""] * 150), tmp_path / "a.svg")
    assert (tmp_path / "a.svg").stat().st_size < 5_000_000


def test_a_name_is_not_taken_for_mathematics(tmp_path):
    draw(session("X10$Y10$\r", "X10$\r", "$$^$\r"), tmp_path / "a.svg")
    assert r"> X10$Y10$\r" in texts(tmp_path / "a.svg") or r"> X10$\r" in texts(tmp_path / "a.svg")


def test_a_picture_of_no_known_kind(tmp_path, trace):
    with pytest.raises(UsageError, match=r"expected a name that ends in \.svg or \.png"):
        draw(trace, tmp_path / "a.pdf", "if1.output1")


def test_a_picture_that_cannot_be_written(tmp_path, trace):
    with pytest.raises(UsageError, match=r"cannot write the picture to .*: no such file"):
        draw(trace, tmp_path / "no" / "a.svg", "if1.output1")


def test_a_picture_for_which_there_is_no_room_leaves_no_half_of_it(tmp_path, trace, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(AxistwinError, match=r"cannot write the picture to .*: no space left"):
        draw(trace, tmp_path / "a.png", "if1.output1")
    assert [*tmp_path.glob("*.png*")] == []
