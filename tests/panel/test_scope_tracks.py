"""Tracks of the oscilloscope: recent changes are stored exactly, older changes as extremes, in limited memory."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.core.units import MS, S
from axistwin.records.traces.signals import COUNT, LEVEL, TEXT
from axistwin.ui.panel.scope import tracks
from axistwin.ui.panel.scope.decimation import line as line_of
from axistwin.ui.panel.scope.decimation import marks, window
from axistwin.ui.panel.scope.tracks import MOST_BYTES, Track, Words


def track_of(*changes, kind=COUNT):
    found = Track(kind)
    found.add(np.array([time_ns for time_ns, _ in changes], np.int64), np.array([value for _, value in changes], float))
    return found


def line(seen):
    return list(zip(seen.times.tolist(), seen.values.tolist(), strict=True))


# Windows with known contents


def test_each_pixel_has_what_was_when_it_began_and_what_came_in_it():
    seen = window(track_of((0, 5), (12, 7), (14, 1), (25, 3)), 0, 40, 4, now_ns=40)
    assert seen.edges.tolist() == [0, 10, 20, 30, 40] and seen.low.tolist() == [5, 1, 1, 3]
    assert seen.high.tolist() == [5, 7, 3, 3]


def test_the_line_has_changes_at_their_times_and_two_points_where_there_are_more_in_a_pixel():
    seen = window(track_of((0, 5), (12, 7), (14, 1), (25, 3)), 0, 40, 4, now_ns=40)

    #                     change     least and greatest   as it began  change  end
    assert line(seen) == [(0, 5), (10, 7), (10, 1), (20, 1), (25, 3), (40, 3)]


def test_a_short_pulse_of_a_level_is_seen_in_its_pixel():
    seen = window(track_of((0, 0), (5_000_100, 1), (5_000_350, 0), kind=LEVEL), 0, 10 * MS, 10, now_ns=10 * MS)
    assert seen.high.tolist() == [0, 0, 0, 0, 0, 1, 0, 0, 0, 0] and not seen.low.any()


def test_nothing_is_known_before_the_first_change_nor_from_now_on():
    seen = window(track_of((15, 2)), 0, 40, 4, now_ns=30)
    assert np.isnan(seen.low).tolist() == [True, False, False, True] and line(seen) == [(15, 2), (30, 2)]


def test_nothing_is_known_while_nobody_was_looking():
    track = track_of((0, 2))
    track.interrupt(10)
    track.add(np.array([30]), np.array([2.0]))
    assert np.isnan(window(track, 0, 40, 4, now_ns=40).low).tolist() == [False, False, True, False]


def test_where_little_has_happened_the_line_is_simply_that():
    track = track_of((5, 0), (12, 7), (14, 1), (25, 3))
    assert line(line_of(track, 13, 40, 100, now_ns=30)) == [(13, 7), (14, 1), (25, 3), (30, 3)]
    assert line(line_of(track, 0, 5, 100, now_ns=30)) == []
    assert line(line_of(track, 0, 40, 4, now_ns=40)) == line(window(track, 0, 40, 4, now_ns=40))


def test_what_is_no_change_is_left_out():
    assert track_of((0, 2), (5, 2), (6, 3)).rows(0, 10).begin.tolist() == [0, 6]


# Comparison with a simple implementation


changes_ = st.lists(st.tuples(st.integers(1, 50), st.integers(-9, 9)), min_size=1, max_size=80)


def stepped(steps):
    """Return samples as changes: without those that are equal to the value before."""
    time_ns, found = 0, []
    for wait_ns, value in steps:
        time_ns += wait_ns
        if not found or found[-1][1] != value:
            found.append((time_ns, value))
    return found


def naive(changes, from_ns, to_ns, pixels):
    """Return the least and the greatest value in each pixel, calculated value by value."""
    edges = [from_ns + (to_ns - from_ns) * n // pixels for n in range(pixels + 1)]
    found = []
    for left, right in pairwise(edges):
        before = [value for time_ns, value in changes if time_ns < left][-1:]
        values = before + [value for time_ns, value in changes if left <= time_ns < right]
        found.append((min(values), max(values)) if values else (None, None))
    return found


@given(changes_, st.integers(0, 500), st.integers(1, 2000), st.integers(1, 60))
def test_windows_are_those_of_a_naive_search(steps, from_ns, width_ns, pixels):
    changes = stepped(steps)
    to_ns = from_ns + width_ns
    seen = window(track_of(*changes), from_ns, to_ns, pixels, now_ns=10_000)
    found = [(None if np.isnan(low) else low, None if np.isnan(high) else high)
             for low, high in zip(seen.low, seen.high, strict=True)]  # fmt: skip
    assert found == naive(changes, from_ns, to_ns, pixels)


@given(changes_, st.integers(0, 500), st.integers(100, 2000), st.integers(1, 60))
def test_the_line_has_two_points_for_a_pixel_at_most_and_shows_all_extremes(steps, from_ns, width_ns, pixels):
    changes = stepped(steps)
    to_ns = from_ns + width_ns
    seen = window(track_of(*changes), from_ns, to_ns, pixels, now_ns=10_000)
    assert sorted(seen.times.tolist()) == seen.times.tolist()
    inside = seen.times[seen.times < to_ns]
    assert max(np.bincount(np.searchsorted(seen.edges, inside, "right")), default=0) <= 2
    expected = [bounds for bounds in naive(changes, from_ns, to_ns, pixels) if bounds != (None, None)]
    if expected:
        expected += [(value, value) for time_ns, value in changes if time_ns == to_ns][-1:]  # the line's last point
        assert seen.values.min() == min(low for low, _ in expected)
        assert seen.values.max() == max(high for _, high in expected)


long_ = st.lists(st.tuples(st.integers(1, 200), st.integers(-9, 9)), min_size=30, max_size=200)


@settings(max_examples=50)
@given(steps=long_, cut=st.integers(1, 20), pixels=st.integers(1, 40))
def test_what_is_old_keeps_its_extremes(steps, cut, pixels):
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("CHANGES", 16), ("ROWS", 8), ("SMALL", 4), ("SHIFTS", (4, 6))):
            patch.setattr(tracks, name, value)
        changes = stepped(steps)
        track = Track(COUNT)
        for at in range(0, len(changes), cut):
            part = changes[at : at + cut]
            track.add(np.array([time_ns for time_ns, _ in part]), np.array([float(value) for _, value in part]))
        to_ns = changes[-1][0] + 1
        seen = window(track, 0, to_ns, pixels, now_ns=to_ns)

    expected = naive(changes, 0, to_ns, pixels)
    for low, high, (least, greatest) in zip(seen.low, seen.high, expected, strict=True):
        assert least is None or (low <= least and high >= greatest)  # an interval may extend into this pixel
    assert np.nanmin(seen.low) == min(value for _, value in changes)
    assert np.nanmax(seen.high) == max(value for _, value in changes)


def test_hours_take_no_more_memory_than_is_told():
    track = Track(COUNT)
    times = np.arange(1 << 15, dtype=np.int64)
    for n in range(200):  # 6.5 million changes in six hours
        track.add((n * len(times) + times) * 3 * MS, np.sin(n + times / 1000) * 1000)
    assert track.nbytes <= MOST_BYTES
    everything = window(track, 0, 200 * len(times) * 3 * MS, 100, now_ns=10**18)
    assert (everything.high > 990).all() and (everything.low < -990).all()


@pytest.mark.parametrize("every_ns", [250_000, 20_000])  # samples of a servo, and fast pulses
def test_of_what_comes_fast_every_larger_interval_keeps_its_extremes(every_ns):
    interval_ns, count = 1 << tracks.SHIFTS[1], 4 * tracks.CHANGES
    times = np.arange(count, dtype=np.int64) * every_ns
    values = np.cumsum(np.random.default_rng(1).integers(-9, 10, count) * 2 + 1).astype(float)
    track = Track(COUNT)
    for part in np.array_split(np.arange(count), 37):
        track.add(times[part], values[part])
    intervals = int(times[-1]) // interval_ns

    seen = window(track, 0, intervals * interval_ns, intervals, now_ns=int(times[-1]))

    edges = np.searchsorted(times, np.arange(intervals + 1) * interval_ns)
    inside = [values[max(first - 1, 0) : end] for first, end in pairwise(edges)]  # with the value before the pixel
    assert seen.low.tolist() == [each.min() for each in inside]
    assert seen.high.tolist() == [each.max() for each in inside]


def test_weeks_find_room_in_larger_intervals():
    track = Track(COUNT)
    times = np.arange(1 << 15, dtype=np.int64)
    for n in range(40):
        track.add((n * len(times) + times) * 20 * S, times.astype(float))  # 300 days
    assert track.nbytes <= MOST_BYTES
    assert track.rows(0, 1 << 62).low[0] == 0 and track.exact_ns > 0


def test_a_lonely_change_of_long_ago_is_still_exact():
    track = track_of((0, 0), (7 * S, 1), (7 * S + 100, 0))
    times = 100 * S + np.arange(200_000, dtype=np.int64) * MS
    track.add(times, np.arange(len(times)) % 2 + 2.0)
    assert (window(track, 6 * S, 8 * S, 100, now_ns=times[-1]).high > 0).sum() == 1 and track.exact_ns > 100 * S


def test_what_is_frozen_does_not_go_on():
    track = track_of((0, 1))
    copy = track.frozen()
    track.add(np.array([5]), np.array([9.0]))
    assert copy.rows(0, 10).begin.tolist() == [0]


# Words


def said(*changes, growing=True):
    words = Words(TEXT, growing)
    words.say(np.array([time_ns for time_ns, _ in changes], np.int64), [text for _, text in changes])
    return words


def test_a_message_that_grows_is_one_mark_where_it_began():
    words = said((0, b""), (10, b"X"), (20, b"X1 "), (30, b"X1 $\r"), (40, b""), (50, b"K\r"))
    assert marks(words, 0, 100, 100) == [(10, r"X1 $\r"), (50, r"K\r")]
    assert words.at(25) == r"X1\x20" and words.at(45) == ""
    assert words.rows(0, 100).last.tolist() == [0, 1, 0, 1]


def test_other_texts_are_marks_whenever_they_change():
    words = said((0, b"jam"), (10, b"jam, push"), growing=False)
    assert marks(words, 0, 100, 100) == [(0, "jam"), (10, "jam, push")]


def test_of_many_words_the_first_in_each_part_of_the_window_is_shown():
    words = said(*((10 * n, b"%d\r" % n) for n in range(10)))
    assert marks(words, 0, 100, 2) == [(0, r"0\r"), (50, r"5\r")]


def test_the_oldest_words_go_in_the_end():
    words = Words(TEXT, True)
    for n in range(tracks.TEXTS + 1):
        words.say(np.array([10 * n]), [b"%d\r" % n])
    assert len(words.changes) <= tracks.TEXTS and words.exact_ns == words.changes[0][0] > 0
    assert len(words.begins) == len(words.messages) and words.at(10 * tracks.TEXTS) == rf"{tracks.TEXTS}\r"
