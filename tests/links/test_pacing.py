"""Virtual time and the wall clock, with a wall clock that is told how late it is."""

import pytest

from axistwin.errors import UsageError
from axistwin.links.pacing import BLOCK_S, Pacer, read_speed
from axistwin.sim.clock import Clock
from axistwin.units import MS, S

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


def test_many_events_are_done_in_blocks(clock, loop):
    def beat():
        while True:
            yield clock.timeout(MS)

    clock.process(beat())
    paced(clock, loop, 1)
    loop.run_to(1)
    assert loop.woken < 2 / BLOCK_S  # a slice may end early on a busy machine


@pytest.mark.parametrize("speed", [1, None])
def test_nothing_is_done_while_nothing_is_due(clock, loop, speed):
    paced(clock, loop, speed)
    loop.run_to(1000)
    assert loop.woken == 0
    assert loop.handles == []


def test_at_full_speed_all_that_is_due_happens_without_the_wall_clock(clock, loop):
    def program():
        for _ in range(10):
            yield clock.timeout(3600 * S)

    clock.process(program())
    paced(clock, loop, None)
    loop.run_to(0)
    assert clock.now == 36_000 * S


def test_at_full_speed_a_bench_that_never_rests_lets_the_loop_look_at_its_sockets(clock, loop):
    def program():
        while True:
            yield clock.timeout(S)

    clock.process(program())
    pacer = paced(clock, loop, None)
    before = clock.now
    pacer.work()  # something comes in while a slice is waiting for its turn: no second one is made
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
    assert pacer.overruns == 1
    assert clock.now == 500 * MS
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
    clock.call_later(10 * MS, lambda: pacer.mark(port))
    loop.run_to(0.005)
    assert port.flushed == 0
    loop.run_to(1)
    pacer.work()
    assert port.flushed == 1


@pytest.mark.parametrize(("text", "speed"), [("1", 1.0), ("0.5", 0.5), ("1e3", 1000.0), ("max", None)])
def test_a_speed_is_a_number_or_max(text, speed):
    assert read_speed(text) == speed


@pytest.mark.parametrize("text", ["", "0", "-1", "fast", "nan", "inf"])
def test_a_bad_speed_is_refused(text):
    with pytest.raises(UsageError, match="no speed"):
        read_speed(text)
