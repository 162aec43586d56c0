"""Virtual time and the wall clock, with a fake wall clock."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.core.units import MOST_NS, MS, S
from axistwin.links import pacing
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.pacing import Pacer, read_speed
from axistwin.sim.clock import Clock

from .fake_loop import Loop


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def loop():
    return Loop()


def paced(clock, loop, speed):
    pacer = Pacer(clock, speed)
    pacer.start(loop)
    return pacer


@pytest.mark.parametrize(("speed", "virtual_s"), [(1, 10), (0.5, 5), (100, 1000)])
def test_virtual_time_keeps_pace_with_the_wall_clock(clock, loop, speed, virtual_s):
    pacer = paced(clock, loop, speed)
    loop.run_to(10)
    pacer.sync()
    assert clock.now == virtual_s * S


def test_an_event_happens_when_the_wall_clock_says(clock, loop):
    happened = []
    clock.call_later(300 * MS, lambda: happened.append((clock.now, loop.now_s)))
    paced(clock, loop, 1)
    loop.run_to(1)
    assert happened == [(300 * MS, 0.3)]


def test_what_comes_in_finds_the_bench_at_the_moment_of_its_arrival(clock, loop):
    pacer = paced(clock, loop, 2)
    loop.now_s = 1.25
    pacer.sync()
    assert clock.now == 2500 * MS


def test_what_a_look_brings_about_happens_in_time(clock, loop):
    happened = []
    clock.call_later(5 * S, lambda: None)  # without the read, the pacer would sleep until then
    pacer = paced(clock, loop, 1)
    loop.run_to(1)
    pacer.inspect(lambda: clock.call_later(30 * MS, lambda: happened.append((clock.now, loop.now_s))))
    loop.run_to(2)
    assert happened == [(1030 * MS, pytest.approx(1.03))]


def test_many_events_are_done_in_blocks(clock, loop):
    def beat():
        while True:
            yield clock.timeout(MS)

    clock.process(beat())
    paced(clock, loop, 1)
    loop.run_to(1)
    assert loop.woken < 2 / pacing.BLOCK_S  # a slice may end early on a busy machine


@pytest.mark.parametrize("speed", [1, None])
def test_nothing_is_done_while_nothing_is_due(clock, loop, speed):
    paced(clock, loop, speed)
    loop.run_to(1000)
    assert loop.woken == 0 and loop.handles == []


def test_at_full_speed_all_that_is_due_happens_without_the_wall_clock(clock, loop):
    def program():
        for _ in range(10):
            yield clock.timeout(3600 * S)

    clock.process(program())
    paced(clock, loop, None)
    loop.run_to(0)
    assert clock.now == 36_000 * S


def test_at_full_speed_what_nobody_waits_for_comes_too_as_far_as_somebody_wants_to_see(clock, loop):
    happened = []
    for time_ns in (3600 * S, 7200 * S):
        clock.background += 1
        clock.call_later(time_ns, lambda: happened.append(clock.now))
    pacer = paced(clock, loop, None)
    loop.run_to(0)
    assert happened == []
    pacer.agenda_ns = 3600 * S
    pacer.work()
    loop.run_to(0)
    assert happened == [3600 * S]


def test_at_full_speed_a_bench_that_never_rests_lets_the_loop_look_at_its_sockets(clock, loop):
    def program():
        while True:
            yield clock.timeout(S)

    clock.process(program())
    pacer, before = paced(clock, loop, None), clock.now
    pacer.work()  # input while a slice is planned: no second slice is planned
    assert clock.now == before
    [handle] = loop.handles
    handle.action()
    assert clock.now > before
    pacer.stop()


def test_falling_behind_is_counted_and_caught_up(clock, loop):
    clock.call_later(100 * MS, lambda: None)
    pacer = paced(clock, loop, 1)
    loop.now_s = 0.5
    loop.run_to(0.5)
    assert pacer.delays.overruns == 1 and clock.now == 500 * MS
    assert pacer.report() == "fell behind the wall clock once, by 400 ms at most"


def test_what_can_never_be_caught_up_is_given_up(clock, loop):
    def program():
        while True:
            yield clock.timeout(S)

    clock.process(program())
    pacer = paced(clock, loop, 1e9)
    loop.now_s = 10
    pacer.sync()
    reached = clock.now
    assert reached < 1e9 * S
    pacer.sync()
    assert clock.now == reached


def test_being_in_time_is_nothing_to_report(clock, loop):
    clock.call_later(100 * MS, lambda: None)
    pacer = paced(clock, loop, 1)
    loop.run_to(1)
    assert pacer.report() is None


def test_a_port_is_flushed_once_when_the_bench_has_been_advanced(clock, loop):
    class Port:
        flushed = 0

        def flush(self):
            self.flushed += 1

    port = Port()
    pacer = paced(clock, loop, 1)
    clock.call_later(10 * MS, lambda: pacer.request_flush(port))
    loop.run_to(0.005)
    assert port.flushed == 0
    loop.run_to(1)
    pacer.work()
    assert port.flushed == 1


# Stops between events

SPEEDS = [1, 1000, None]


def eventful(clock, log):
    """Schedule three events at 10 ms, one of which causes a fourth in the same nanosecond, and another event 1 ns
    later.
    """
    for name in "abc":
        clock.call_later(10 * MS, lambda name=name: log.append(name))
    clock.call_later(10 * MS, lambda: clock.call_later(0, lambda: log.append("d")))
    clock.call_later(10 * MS + 1, lambda: log.append("later"))


@pytest.mark.parametrize("speed", SPEEDS)
def test_stopped_while_something_happens_time_stands_at_the_end_of_that_nanosecond(clock, loop, speed):
    log, pacer = [], Pacer(clock, speed)
    clock.call_later(10 * MS, pacer.stop)
    eventful(clock, log)
    pacer.start(loop)
    loop.run_to(1)
    assert (clock.now, log, pacer.running) == (10 * MS, list("abcd"), False)
    pacer.sync()
    loop.run_to(2)
    assert (clock.now, loop.handles) == (10 * MS, [])
    pacer.start(loop)
    loop.run_to(3)
    assert log == [*"abcd", "later"]


@pytest.mark.parametrize("speed", [1, 1000])
def test_stopped_by_what_is_due_when_something_comes_in(clock, loop, speed):
    log, pacer = [], paced(clock, loop, speed)
    clock.call_later(10 * MS, pacer.stop)
    eventful(clock, log)
    loop.now_s = 1
    pacer.sync()
    assert (clock.now, log) == (10 * MS, list("abcd"))


@pytest.mark.parametrize("speed", SPEEDS)
def test_what_has_been_said_until_it_stops_is_handed_over(clock, loop, speed):
    flushed = []

    class Port:
        def flush(self):
            flushed.append(clock.now)

    pacer = Pacer(clock, speed)
    clock.call_later(10 * MS, lambda: (pacer.request_flush(Port()), pacer.stop()))
    pacer.start(loop)
    loop.run_to(1)
    assert flushed == [10 * MS]


def test_stopped_and_started_while_something_happens_it_goes_on(clock, loop):
    log = []
    clock.call_later(10 * MS, lambda: (pacer.stop(), pacer.start(loop)))
    eventful(clock, log)
    pacer = paced(clock, loop, 1)
    loop.run_to(1)
    assert log == [*"abcd", "later"]


@pytest.mark.parametrize("speed", [1, None])
def test_what_comes_in_finds_the_end_of_a_nanosecond_even_if_a_slice_ended_in_it(clock, loop, speed, monkeypatch):
    """A slice ends after two events; input first completes the events of this nanosecond."""
    log = []
    eventful(clock, log)
    looks = iter([0.0, 0.0, 0.0, 9.0, 20.0, 29.0] if speed else [0.0, 0.0, 9.0])
    monkeypatch.setattr("axistwin.links.pacing.perf_counter", lambda: next(looks))
    pacer = paced(clock, loop, speed)
    loop.now_s = 0.5
    if speed is not None:
        pacer.work()
    assert log == list("ab")
    pacer.sync()
    assert (clock.now, log) == (10 * MS, list("abcd"))


@pytest.mark.parametrize("speed", SPEEDS)
def test_what_comes_in_while_time_stands_still_finds_all_that_is_due_done(clock, speed):
    log = []
    clock.call_later(0, lambda: log.append("first"))
    pacer = Pacer(clock, speed)
    pacer.sync()
    assert (clock.now, log) == (0, ["first"])
    clock.call_later(0, lambda: log.append("second"))
    pacer.work()
    assert (clock.now, log) == (0, ["first", "second"])


# A change of speed while running


def test_another_speed_counts_from_now_on(clock, loop):
    clock.call_later(100 * S, lambda: None)
    pacer = paced(clock, loop, 1)
    loop.run_to(2)
    pacer.speed = 10
    assert clock.now == 2 * S
    loop.run_to(3)
    pacer.sync()
    assert clock.now == 12 * S
    pacer.speed = 0.5
    loop.run_to(5)
    pacer.sync()
    assert (clock.now, pacer.speed) == (13 * S, 0.5)


def test_as_fast_as_it_goes_and_back(clock, loop):
    seconds = []
    for second in range(1, 40):
        clock.call_later(second * S, lambda: seconds.append(clock.now // S))
    clock.call_later(20 * S, lambda: setattr(pacer, "speed", 1))
    pacer = paced(clock, loop, 1)
    loop.run_to(2.5)
    pacer.speed = None
    loop.run_to(2.5)  # a busy machine may need several slices
    assert seconds[-1] == 20
    loop.run_to(4)
    pacer.sync()
    assert (clock.now, seconds[-1]) == (21_500 * MS, 21)


def test_the_speed_of_what_stands_still_counts_when_it_is_started(clock, loop):
    pacer = Pacer(clock, 1)
    pacer.speed = 4
    pacer.start(loop)
    loop.run_to(2)
    pacer.sync()
    assert clock.now == 8 * S


# Calls of a pacer in all states


@pytest.mark.parametrize("speed", SPEEDS)
def test_it_is_being_advanced_while_something_happens_and_only_then(clock, loop, speed):
    seen = []
    clock.call_later(10 * MS, lambda: seen.append(pacer.advancing))
    pacer = Pacer(clock, speed)
    pacer.subscribe(lambda: seen.append(pacer.advancing))
    pacer.start(loop)
    loop.run_to(1)
    assert True in seen and pacer.advancing is False
    assert seen.count(True) == 1


def test_it_is_not_being_advanced_any_more_when_something_went_wrong(clock, loop):
    def fail():
        raise ArithmeticError

    clock.call_later(0, fail)
    pacer = Pacer(clock, None)
    with pytest.raises(ArithmeticError):
        pacer.start(loop)
    assert pacer.advancing is False


def test_what_comes_in_while_something_happens_does_not_advance_it_further(clock, loop):
    log, pacer = [], Pacer(clock, None)
    clock.call_later(10 * MS, lambda: (pacer.sync(), pacer.work(), log.append("first")))
    clock.call_later(10 * MS, lambda: log.append("second"))
    pacer.start(loop)
    assert log == ["first", "second"]


def test_by_hand_it_is_being_advanced_while_something_happens_too():
    bench, seen = Bench(), []
    pacer = ManualPacer(bench)
    bench.clock.call_later(10 * MS, lambda: seen.append(pacer.advancing))
    pacer.advance(20 * MS)
    assert (seen, pacer.advancing, pacer.passes > 0) == ([True], False, True)


@pytest.mark.parametrize("speed", SPEEDS)
def test_what_comes_in_together_has_no_pass_in_between(clock, loop, speed):
    pacer = paced(clock, loop, speed)
    pacer.sync()
    passes = pacer.passes
    pacer.sync()
    pacer.work()
    assert pacer.passes == passes
    clock.call_later(0, lambda: None)
    pacer.sync()
    assert pacer.passes == passes + 1


def test_blocks_are_counted_beside_those_that_were_late(clock, loop):
    for second in (1, 2, 3, 3, 5, 6, 8):
        clock.call_later(second * S, lambda: None)
    pacer = paced(clock, loop, 1)
    loop.run_to(4)
    assert (pacer.delays.blocks, pacer.delays.overruns) == (3, 0)
    loop.now_s = 7  # two of the events are late, in one block
    loop.run_to(20)
    assert (pacer.delays.blocks, pacer.delays.overruns) == (5, 1)


def test_time_that_cannot_stand_in_a_trace_does_not_come(clock, loop):
    pacer = paced(clock, loop, 1e6)
    loop.run_to(10_000)
    pacer.sync()
    assert clock.now == MOST_NS - 1


def test_another_clock_is_advanced_from_where_it_is(clock, loop):
    pacer = paced(clock, loop, 2)
    loop.run_to(5)
    other, log = Clock(), []
    other.run_to(100 * S)
    other.call_later(2 * S, lambda: log.append(other.now))
    pacer.pace(other)
    reached = clock.now
    loop.run_to(7)
    pacer.sync()
    assert (log, other.now, clock.now, other.patient) == ([102 * S], 104 * S, reached, False)


@pytest.mark.parametrize(("text", "speed"), [("1", 1.0), ("0.5", 0.5), ("1e3", 1000.0), ("max", None)])
def test_a_speed_is_a_number_or_max(text, speed):
    assert read_speed(text) == speed


@pytest.mark.parametrize("text", ["", "0", "-1", "fast", "nan", "inf", "1e7", "1e300"])
def test_a_bad_speed_is_refused(text):
    with pytest.raises(UsageError, match="invalid speed"):
        read_speed(text)
