"""The oscilloscope without its user interface: recording, trigger, measurement, frames and files."""

from base64 import b64decode
from math import isnan

import numpy as np
import pytest

from axistwin import Bench, tracing
from axistwin.core.errors import UsageError
from axistwin.core.units import MS, S
from axistwin.records.traces.reading import read
from axistwin.records.traces.signals import COUNT, LEVEL, catalogue
from axistwin.ui.panel.scope.cursors import between, duration, nearest_edge, next_edge, rate, value_at
from axistwin.ui.panel.scope.frames import FULL, TOP, frame
from axistwin.ui.panel.scope.meaning import meanings
from axistwin.ui.panel.scope.recorder import MOST_SIGNALS, Recorder
from axistwin.ui.panel.scope.saving import saved
from axistwin.ui.panel.scope.screen import Screen, first_choice, searched
from axistwin.ui.panel.scope.tracks import Track
from axistwin.ui.panel.scope.triggers import AUTO, DOWN, EITHER, NORMAL, SINGLE, UP, Trigger

from ..benches import bench_of

SIGNALS = ("if1.input1", "if1.X.pulses", "if1.X.velocity", "if1.controller_says")


@pytest.fixture
def bench():
    bench = Bench()
    if1 = bench.add("if1")
    bench.run(1.5)
    for message in (b"(", b"U61\r"):
        if1.serial.write(message)
        bench.run(1.2)
    return bench


@pytest.fixture
def recorder(bench):
    recorder = Recorder()
    recorder.attach(bench)
    return recorder


@pytest.fixture
def screen(recorder):
    screen = Screen(recorder)
    screen.show(SIGNALS)
    return screen


def pulse(bench, seconds=0.01):
    bench["if1"].pins["input1"].drive(True)
    bench.run(seconds)
    bench["if1"].pins["input1"].drive(False)


def move(bench, text=b"X400@1000S1$\r", seconds=2.0):
    bench["if1"].serial.write(text)
    bench.run(seconds)


def track_of(*changes, kind=COUNT):
    found = Track(kind)
    found.add(np.array([time_ns for time_ns, _ in changes], np.int64), np.array([value for _, value in changes], float))
    return found


# Recording


def test_what_is_recorded_is_what_a_trace_has(bench, recorder, screen, tmp_path):
    with tracing(bench, tmp_path / "a.csv", SIGNALS):
        move(bench)
        pulse(bench)
        bench.run(0.1)
    recorder.catch_up()
    trace = read(tmp_path / "a.csv")
    for name in ("if1.input1", "if1.X.pulses", "if1.X.velocity"):
        times, values = trace.tracks[name].columns()
        rows = recorder.record.tracks[name].rows(0, bench.now)
        assert rows.begin.tolist() == times.tolist() and rows.last.tolist() == values.tolist()


def test_other_signals_leave_those_that_stay_as_they_are(bench, recorder, screen):
    move(bench)
    recorder.catch_up()
    before = recorder.record.tracks["if1.X.pulses"].rows(0, bench.now).begin.tolist()
    screen.show(("if1.X.pulses", "if1.Y.pulses"))
    move(bench)
    recorder.catch_up()
    rows = recorder.record.tracks["if1.X.pulses"].rows(0, bench.now)
    assert rows.begin.tolist()[: len(before)] == before and rows.last.tolist() == list(range(801))
    assert isnan(value_at(recorder.record.tracks["if1.input1"], bench.now))


def test_signals_that_come_back_have_a_gap(bench, recorder, screen):
    screen.show(())
    bench.run(1.0)
    away_ns = bench.now
    screen.show(("if1.input1",))
    bench.run(1.0)
    recorder.catch_up()
    track = recorder.record.tracks["if1.input1"]
    assert isnan(value_at(track, away_ns - 1)) and value_at(track, bench.now) == 0


def test_all_that_people_look_at_is_recorded_once(recorder, screen):
    other = Screen(recorder)
    other.show(("if1.X.pulses", "if1.led"))
    assert set(recorder.record.tracks) == {*SIGNALS, "if1.led"}
    recorder.leave(screen)
    recorder.leave(other)  # the signals of the last screen are still recorded
    other.show(("if1.led",))
    assert {name for name, track in recorder.record.tracks.items() if not isnan(value_at(track, 4 * S))} == {"if1.led"}


def test_another_bench_has_a_record_of_its_own(bench, recorder, screen):
    move(bench)
    recorder.catch_up()
    again = Bench()
    again.add("if1")
    recorder.attach(again)
    again.run(1.0)
    bench.run(1.0)
    assert recorder.catch_up().now_ns == 1 * S
    assert recorder.record.tracks["if1.X.pulses"].rows(0, 10 * S).last.tolist() == [0]


def test_there_is_a_limit_for_all_together(recorder, screen):
    bench = Bench()
    bench.add("smartmotor", "motor")
    recorder.attach(bench)
    names = [name for name in recorder.signals if ".R" in name]
    with pytest.raises(UsageError, match=f"too many oscilloscope signals: expected at most {MOST_SIGNALS} "):
        recorder.want("somebody", names[: MOST_SIGNALS + 1])
    with pytest.raises(UsageError, match="20 signals are too many for one screen: choose 16 or fewer"):
        screen.show(names[:20])


def test_signals_are_found_by_a_part_of_their_names_and_by_patterns(recorder):
    signals = list(recorder.signals.values())
    assert [signal.full for signal in searched(signals, "x.pul")] == []
    assert [signal.full for signal in searched(signals, "X.pul, *.led")] == ["if1.led", "if1.X.pulses"]
    assert len(searched(signals, "")) == len(signals)


def test_who_has_chosen_nothing_sees_how_axes_move_and_what_is_said(recorder):
    assert first_choice(list(recorder.signals.values())) == [
        "if1.X.pulses", "if1.Y.pulses", "if1.Z.pulses", "if1.host_says", "if1.controller_says",
    ]  # fmt: skip


# Visible time


def test_a_live_screen_shows_the_newest(bench, recorder, screen):
    recorder.catch_up()
    screen.span_ns = S
    assert screen.edges == (bench.now - S, bench.now)
    bench.run(1.0)
    recorder.catch_up()
    assert screen.edges == (bench.now - S, bench.now)


def test_a_paused_screen_stays_while_the_bench_goes_on(bench, recorder, screen):
    recorder.catch_up()
    screen.pause()
    before = screen.edges
    move(bench)
    recorder.catch_up()
    assert screen.edges == before and screen.tracks["if1.X.pulses"].rows(0, bench.now).last.tolist() == [0]
    screen.live()
    assert screen.edges[1] == bench.now


def test_zooming_keeps_what_is_under_the_pointer_and_panning_pauses(bench, recorder, screen):
    recorder.catch_up()
    screen.pan(-0.5)
    assert screen.frozen is not None
    from_ns, to_ns = screen.edges
    assert to_ns == bench.now - S
    at_ns = screen.time_at(0.25)
    screen.zoom(0.1, 0.25)
    assert abs(screen.time_at(0.25) - at_ns) <= 1 and screen.span_ns == (to_ns - from_ns) // 10
    screen.zoom(1e-12)
    assert screen.span_ns == 1000
    screen.fit()
    assert screen.edges == (0, bench.now)


# Triggers


CHANGES = ((0, 0), (10, 5), (20, 2), (30, 8), (40, 1))


@pytest.mark.parametrize(("slope", "first", "last"), [
    (UP, 10, 30), (DOWN, 20, 40), (EITHER, 10, 40)])  # fmt: skip
def test_a_number_that_passes_a_value_is_an_edge(slope, first, last):
    trigger, track = Trigger(slope=slope, value=3), track_of(*CHANGES)
    found = trigger.edges(track, 1, 100)
    assert (found[0], found[-1]) == (first, last) and trigger.edges(track, 41, 100) == []


def test_to_come_to_the_value_is_enough_on_the_way_up():
    assert Trigger(value=5).edges(track_of(*CHANGES), 0, 100)[0] == 10
    assert Trigger(value=6).edges(track_of(*CHANGES), 0, 100)[0] == 30


def test_what_a_signal_begins_with_is_no_edge():
    assert Trigger().edges(track_of((5, 1), kind=LEVEL), 0, 100) == []


def test_the_window_is_fixed_to_the_newest_edge_with_enough_behind_it(bench, recorder, screen):
    screen.trigger.mode, screen.trigger.signal = NORMAL, "if1.input1"
    screen.trigger.slope, screen.trigger.place = UP, 0.25
    screen.span_ns = 100 * MS
    screen.arm()
    at_ns = bench.now
    recorder.catch_up()
    assert screen.edges[1] == bench.now and screen.waiting

    pulse(bench)
    bench.run(0.05)
    recorder.catch_up()
    assert screen.waiting  # three quarters of the screen must follow the edge

    bench.run(0.05)
    recorder.catch_up()
    assert screen.edges == (at_ns - 25 * MS, at_ns + 75 * MS) and not screen.waiting

    bench.run(10.0)
    recorder.catch_up()
    assert screen.edges[0] == at_ns - 25 * MS
    screen.trigger.mode = AUTO
    assert screen.edges[1] == bench.now and screen.waiting


def test_single_finds_the_first_edge_and_pauses_even_if_nobody_looks_for_a_long_time(bench, recorder, screen):
    screen.trigger.mode, screen.trigger.signal, screen.trigger.slope = SINGLE, "if1.input1", UP
    screen.span_ns = 100 * MS
    screen.arm()
    at_ns = bench.now
    for _ in range(3):
        pulse(bench)
        bench.run(1.0)
    recorder.catch_up()
    assert screen.frozen is not None and screen.edges == (at_ns - 50 * MS, at_ns + 50 * MS)
    screen.live()
    assert screen.frozen is None and screen.waiting


def test_words_are_a_trigger_too(bench, recorder, screen):
    screen.trigger.mode, screen.trigger.signal = NORMAL, "if1.controller_says"
    screen.span_ns = 10 * MS
    screen.arm()
    bench["if1"].serial.write(b"E\r")
    bench.run(0.1)
    recorder.catch_up()
    assert screen.edges[0] < screen.hit_ns < screen.edges[1]
    assert recorder.record.tracks["if1.controller_says"].at(screen.hit_ns) == "C"


# Cursors


def test_cursors_measure_values_extremes_and_the_mean_over_time():
    track = track_of((0, 10), (100, 20), (130, 0))
    found = between(track, 50, 150)
    assert (found.a, found.b, found.difference) == (10, 0, -10) and (found.low, found.high) == (0, 20)
    assert found.mean == (50 * 10 + 30 * 20 + 20 * 0) / 100 and between(track, 150, 50).mean == found.mean


def test_what_nobody_knows_is_not_made_up():
    found = between(track_of((100, 1)), 50, 150)
    assert isnan(found.a) and found.b == 1
    assert isnan(found.low) and isnan(found.mean)


def test_the_mean_of_old_times_is_that_of_all_that_happened():
    track = Track(COUNT)
    times = np.arange(300_000, dtype=np.int64) * MS
    values = np.arange(300_000) % 4 * 1.0
    track.add(times, values)
    assert track.exact_ns > 60 * S and between(track, 0, 60 * S).mean == pytest.approx(1.5, abs=0.01)
    assert between(track, 0, 60 * S).high == 3


def test_cursors_find_edges():
    tracks = [track_of((10, 1), (50, 2)), track_of((30, 1))]
    assert nearest_edge(tracks, 33, 5) == 30 and nearest_edge(tracks, 40, 5) is None
    assert next_edge(tracks, 10, 100) == 30 and next_edge(tracks, 50, 0) == 30
    assert next_edge(tracks, 50, 100) is None


def test_a_cursor_jumps_to_an_edge_nearby_unless_told_otherwise(bench, recorder, screen):
    recorder.catch_up()
    edge_ns = bench.now
    pulse(bench)
    bench.run(1.0)
    recorder.catch_up()
    screen.pixels = 1000
    place = (edge_ns - screen.edges[0]) / screen.span_ns

    screen.put_cursor("a", place + 0.0015)
    assert screen.cursors.a_ns == edge_ns
    screen.cursors.snap = False
    screen.put_cursor("b", place + 0.0015)
    assert screen.cursors.b_ns == edge_ns + 3 * MS
    screen.move_cursor(-1)
    assert screen.cursors.b_ns == edge_ns + 1 * MS
    screen.jump_cursor(forward=True)
    assert screen.cursors.b_ns == edge_ns + 10 * MS


def test_a_click_in_a_lane_finds_the_edges_of_its_signal_only():
    recorder = Recorder()
    bench = Bench()
    if1 = bench.add("if1")
    recorder.attach(bench)
    screen = Screen(recorder, span_ns=200 * MS, pixels=1000)
    screen.show(("if1.input1", "if1.input2"))
    for _ in range(100):  # input 2 changes every millisecond
        if1.pins["input2"].drive(not if1.pins["input2"].level)
        bench.run(0.001)
        if bench.now == 40 * MS:
            bench.run(0.0003)
            if1.pins["input1"].drive(True)
    recorder.catch_up()
    edge_ns = 40 * MS + 300_000

    def clicked(lane):
        screen.put_cursor("a", (edge_ns + 600_000 - screen.edges[0]) / screen.span_ns, lane)
        return screen.cursors.a_ns

    assert clicked("if1.input1") == edge_ns and clicked("if1.input2") == clicked(None) == edge_ns + MS


def test_times_are_told_in_the_unit_that_suits_them():
    assert [duration(time_ns) for time_ns in (5, 2500, 12_500_000, -3 * S)] == ["5 ns", "2.5 µs", "12.5 ms", "-3 s"]
    assert rate(-4 * MS) == "250 Hz" and rate(0) == "–"


# Messages to the browser


def points(signal):
    return np.frombuffer(b64decode(signal["data"]), "<u2").reshape(-1, 2).tolist()


def test_a_frame_has_places_and_values_as_parts_of_the_window(bench, recorder, screen):
    screen.span_ns = 2 * S
    screen.show(("if1.input1",))
    bench.run(1.0)
    pulse(bench, 0.5)
    bench.run(0.5)
    recorder.catch_up()
    sent = frame(screen)
    assert points(sent["signals"][0]) == [[0, 0], [round(FULL / 2), TOP], [round(FULL * 0.75), 0], [FULL, 0]]
    assert (sent["from"], sent["to"], sent["axis"]) == ((bench.now - 2 * S) / S, bench.now / S, "s")


def test_numbers_are_drawn_between_round_limits_and_words_are_marks(bench, recorder, screen):
    move(bench)
    bench["if1"].serial.write(b"E\r")
    bench.run(0.1)
    recorder.catch_up()
    screen.span_ns = 3 * S
    pulses, says = (frame(screen)["signals"][n] for n in (1, 3))
    assert (pulses["range"], pulses["now"], pulses["unit"]) == ("0 … 400", "400", "pulses")
    assert [text for _, text in says["words"]] == [r"C\r"]


def test_a_frame_carries_two_points_for_a_pixel_at_most(bench, recorder, screen):
    move(bench, b"X4000@2000S1$\r", 4.0)
    recorder.catch_up()
    screen.span_ns, screen.pixels = 4 * S, 200
    for signal in frame(screen)["signals"]:
        assert len(points(signal)) <= 2 * screen.pixels + 1


def test_short_times_long_after_the_beginning_have_short_numbers(bench, recorder, screen):
    bench.run(36_000.0)
    recorder.catch_up()
    screen.span_ns = 20_000
    sent = frame(screen)
    assert sent["axis"].startswith("µs after 36003.")
    assert sent["to"] - sent["from"] == pytest.approx(20) and abs(sent["to"]) < 10_000


def test_a_flat_lane_is_folded_beside_others_until_it_changes_or_the_user_unfolds_it(bench, recorder, screen):
    screen.show(("if1.X.pulses", "if1.input1", "if1.input2"))
    assert screen.folded_now == frozenset(), "all are flat"
    pulse(bench)
    recorder.catch_up()
    assert screen.folded_now == {"if1.X.pulses", "if1.input2"}
    screen.folded["if1.input2"] = False
    assert screen.folded_now == {"if1.X.pulses"}
    move(bench)
    recorder.catch_up()
    screen.folded["if1.input1"] = True
    assert screen.folded_now == {"if1.input1"}
    screen.lanes = False
    assert screen.folded_now == frozenset()


def test_an_emergency_stop_and_a_fault_are_marked_across_all_lanes(bench, recorder, screen):
    screen.span_ns = 10 * S
    at_ns = bench.now
    bench["if1"].pins["estop"].drive(False)
    bench.run(0.5)
    bench.faults.add("stuck", "if1.input1", name="glue", level=True)
    bench.run(0.1)
    recorder.catch_up()
    told = [what for _, what in frame(screen)["alarms"]]
    assert told == [f"emergency stop, {at_ns / S:.3f} s", f"fault glue, {at_ns / S + 0.5:.3f} s"]


def test_a_signal_has_the_name_the_note_and_the_unit_of_the_machine():
    bench = bench_of("if1", X={"units": {"per": 80, "of": "mm"}})()
    bench.wires.append(("if1.output1", "if1.input1"))
    found = meanings(bench, catalogue(bench), {"if1.input2": "Start"})
    names = ("if1.X.pulses", "if1.X.velocity", "if1.output1", "if1.input2", "if1.host_says", "if1.controller_says")
    assert [(found[name].title, found[name].note) for name in names] == [
        ("X position", ""), ("X velocity", ""), ("Output 1", "to input 1"), ("Input 2", "Start"), ("Host", ""),
        ("IF1", ""),
    ]  # fmt: skip
    assert (found["if1.X.velocity"].shown_unit, found["if1.X.velocity"].number(-4000)) == ("mm/s", "\u221250.00")


# Saving


@pytest.mark.parametrize("suffix", [".csv", ".vcd", ".parquet"])
def test_a_saved_trace_is_what_tracing_would_have_written(bench, recorder, screen, tmp_path, suffix):
    begin_ns = bench.now
    with tracing(bench, tmp_path / f"a{suffix}", SIGNALS):
        move(bench)
        bench["if1"].serial.write(b"E\r")
        pulse(bench)
        bench.run(0.5)
    record = recorder.catch_up()
    signals = {name: recorder.signals[name] for name in SIGNALS}

    (tmp_path / f"b{suffix}").write_bytes(saved(record, signals, begin_ns, bench.now, suffix))
    one, other = read(tmp_path / f"a{suffix}"), read(tmp_path / f"b{suffix}")
    assert one.about == other.about and (one.begin_ns, one.end_ns) == (other.begin_ns, other.end_ns)
    for name, track in one.tracks.items():
        assert track.times == other.tracks[name].times and list(track.values) == list(other.tracks[name].values)


def test_a_part_of_it_begins_with_what_was_then(bench, recorder, screen, tmp_path):
    move(bench, seconds=0.3)
    from_ns, before = bench.now, bench["if1"].axes["X"].position
    bench.run(0.0505)
    record = recorder.catch_up()
    path = tmp_path / "a.csv"
    path.write_bytes(saved(record, {"if1.X.pulses": recorder.signals["if1.X.pulses"]}, from_ns, bench.now, ".csv"))
    track = read(path).tracks["if1.X.pulses"]
    assert (track.times[0], track.values[0]) == (from_ns, before)
    assert list(track.values) == list(range(before, bench["if1"].axes["X"].position + 1))


def test_of_old_times_a_trace_says_that_it_has_extremes_only(recorder, screen, tmp_path):
    track = recorder.record.tracks["if1.X.pulses"]
    times = 10 * S + np.arange(200_000, dtype=np.int64) * MS
    track.add(times, np.arange(200_000.0))
    recorder.record.now_ns = int(times[-1])
    path = tmp_path / "a.csv"
    signals = {"if1.X.pulses": recorder.signals["if1.X.pulses"]}
    path.write_bytes(saved(recorder.record, signals, 0, int(times[-1]), ".csv"))
    trace = read(path)
    assert trace.about["summary"].startswith("before 1") and len(trace.tracks["if1.X.pulses"]) < 150_000
    assert max(trace.tracks["if1.X.pulses"].values) == 199_999


@pytest.mark.parametrize(("suffix", "begins"), [(".png", b"\x89PNG"), (".svg", b"<?xml")])
def test_a_picture_of_it(bench, recorder, screen, suffix, begins):
    move(bench)
    bench["if1"].serial.write(b"E\r")
    bench.run(0.2)
    record = recorder.catch_up()
    picture = saved(record, {name: recorder.signals[name] for name in SIGNALS}, *screen.edges, suffix)
    assert picture.startswith(begins)
    assert suffix == ".png" or b"velocity" in picture


def test_a_picture_has_the_cursors_and_no_message_from_before_its_time(bench, recorder, screen):
    screen.show(("if1.input1", "if1.host_says"))
    bench["if1"].serial.write(b"EARLY\r")
    bench.run(2.0)
    from_ns = bench.now
    pulse(bench)
    bench["if1"].serial.write(b"LATE\r")
    bench.run(1.0)
    signals = {name: recorder.signals[name] for name in screen.names}
    cursors = {"A": from_ns + 100 * MS, "B": from_ns + 280 * MS}
    picture = saved(recorder.catch_up(), signals, from_ns, bench.now, ".svg", cursors).decode()
    assert "B   B − A 180 ms" in picture and ">A<" in picture
    assert "LATE" in picture and "EARLY" not in picture
