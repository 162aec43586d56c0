"""Virtual time in integer nanoseconds."""

from hypothesis import given, settings
from hypothesis import strategies as st
from simpy import Interrupt

from axistwin import Bench
from axistwin.sim.clock import Clock, interrupt, kill


def test_time_is_an_integer_and_stands_at_the_end_of_a_run():
    clock = Clock()
    clock.run_to(7)
    clock.run_to(7)
    assert clock.now == 7 and type(clock.now) is int


def test_what_is_due_at_the_end_of_a_run_has_happened_also_what_it_brings_about():
    clock, log = Clock(), []

    def procedure():
        yield clock.timeout(5)
        log.append(clock.now)
        yield clock.timeout(0)
        log.append("then")

    clock.process(procedure())
    clock.run_to(5)
    assert log == [5, "then"]


def test_events_at_the_same_nanosecond_happen_in_the_order_of_scheduling():
    clock, log = Clock(), []
    for name in "abc":
        clock.call_later(3, lambda name=name: log.append(name))
    clock.run_to(3)
    assert log == ["a", "b", "c"]


def test_a_killed_procedure_is_not_resumed_and_tidies_up():
    clock, log = Clock(), []

    def procedure():
        try:
            yield clock.timeout(5)
            log.append("resumed")
        finally:
            log.append("tidied")

    process = clock.process(procedure())
    clock.run_to(1)
    kill(process)
    clock.run_to(10)
    assert log == ["tidied"]


def test_a_procedure_can_be_killed_before_it_began():
    clock, log = Clock(), []

    def procedure():
        log.append("began")
        yield clock.timeout(5)

    kill(clock.process(procedure()))
    clock.run_to(10)
    assert log == []


def test_the_next_event_is_known():
    clock = Clock()
    assert clock.next_event_ns() is None
    clock.call_later(4, lambda: None)
    assert clock.next_event_ns() == 4


def test_an_onlooker_looks_when_a_nanosecond_is_over_in_which_something_happened():
    clock, seen, state = Clock(), [], []
    for at_ns in (3, 3, 5, 9):
        clock.call_later(at_ns, lambda: state.append(clock.now))
    unsubscribe = clock.subscribe(lambda: seen.append((clock.now, len(state))))
    clock.run_to(7)
    state.append("by hand")
    clock.run_to(9)
    assert seen == [(0, 0), (3, 2), (5, 3), (7, 4)]
    unsubscribe()
    clock.call_later(1, lambda: None)
    clock.run_to(20)
    assert len(seen) == 4 and "step" not in vars(clock)


class Busy:
    """A clock with procedures that schedule further events at random; all events are recorded."""

    def __init__(self, plans):
        self.clock, self.log, self._left = Clock(), [], 60
        for number, waits in enumerate(plans):
            self.clock.process(self._procedure(number, waits))

    def _procedure(self, number, waits):
        for wait_ns in waits:
            yield self.clock.timeout(wait_ns)
            self.note(number)

    def note(self, what):
        """Record an event, and schedule another event, up to a limit."""
        self.log.append((self.clock.now, what))
        self._left -= 1
        if self._left > 0 and len(self.log) % 3 == 0:
            self.clock.call_later(len(self.log) % 2, lambda: self.note(("set off by", what)))


PLANS = st.lists(st.lists(st.integers(0, 3), max_size=5), max_size=4)
MOMENTS = st.lists(st.integers(0, 12), max_size=5).map(sorted)


@settings(max_examples=100, deadline=None)
@given(PLANS, MOMENTS)
def test_what_is_done_after_all_is_done_where_it_would_be_after_running_to_that_time(plans, moments):
    first, second = Busy(plans), Busy(plans)
    for number, moment in enumerate(moments):
        first.clock.run_to(moment)
        first.note(("from outside", number))
    first.clock.run_to(20)
    for number, moment in enumerate(moments):
        second.clock.call_last(moment, lambda number=number: second.note(("from outside", number)))
    second.clock.run_to(20)
    assert second.log == first.log


def test_the_same_on_a_bench_with_a_controller():
    """Characters and levels come at 0, during a character, at its end, and twice in the same nanosecond."""
    character_ns = 1_145_833
    moments = (0, character_ns // 3, 1_100_000_000, 1_100_000_000, 1_100_000_000 + character_ns, 1_300_000_000)

    def run(by_hand):
        bench, log = Bench(), []
        if1 = bench.add("if1")
        if1.serial.subscribe_received(lambda byte, errors: log.append((bench.now, byte, errors)))
        for pin in if1.pins.values():
            pin.subscribe(lambda pin: log.append((bench.now, pin.name, pin.level)))

        def act():
            log.append((bench.now, "act"))
            if1.serial.write(b"(E")
            if1.pins["input1"].drive(not if1.pins["input1"].level)

        for moment in moments:
            if by_hand:
                bench.clock.run_to(moment)
                act()
            else:
                bench.clock.call_last(moment, act)
        bench.clock.run_to(3_000_000_000)
        assert len(log) > 12
        return log

    assert run(by_hand=True) == run(by_hand=False)


def test_what_is_taken_back_leaves_nothing_behind():
    clock, log = Clock(), []
    clock.call_later(3, lambda: log.append("other"))
    take_back = clock.call_last(3, lambda: log.append("done"))
    clock.call_last(9, lambda: log.append("late"))()
    take_back()
    take_back()
    assert clock.next_event_ns() == 3
    clock.run_to(5)
    assert (log, clock.quiet) == (["other"], True)


def test_taken_back_when_it_has_been_done_it_has_been_done():
    clock, log = Clock(), []
    take_back = clock.call_last(3, lambda: log.append("done"))
    clock.run_to(3)
    take_back()
    clock.run_to(9)
    assert log == ["done"]


def interrupted(clock, log, again=lambda: None):
    """Start a procedure that waits, and records interrupts."""
    try:
        while True:
            try:
                yield clock.timeout(5)
                log.append("resumed")
            except Interrupt:
                log.append(clock.now)
                again()
    finally:
        log.append("tidied")


def test_a_procedure_is_interrupted_once_however_often_that_is_asked_for():
    clock, log = Clock(), []
    process = clock.process(interrupted(clock, log))
    clock.run_to(1)
    interrupt(process)
    interrupt(process)
    assert log == []
    clock.run_to(3)
    assert log == [1]
    interrupt(process)
    clock.run_to(4)
    assert log == [1, 3] and not clock.interrupted


def test_a_procedure_that_is_over_is_not_interrupted():
    clock, log = Clock(), []

    def procedure():
        yield clock.timeout(1)
        log.append("done")

    process = clock.process(procedure())
    clock.run_to(1)
    interrupt(process)
    clock.run_to(2)
    assert log == ["done"]


def test_a_procedure_does_not_interrupt_itself():
    clock, log = Clock(), []
    process = clock.process(interrupted(clock, log, lambda: interrupt(process)))
    clock.run_to(1)
    interrupt(process)
    clock.run_to(2)
    assert log == [1]


def test_what_is_killed_with_an_interrupt_on_its_way_is_not_resumed():
    """A fault and a loss of power come in the same nanosecond, in either order; the procedure is not resumed."""
    clock, log = Clock(), []
    first, second = (clock.process(interrupted(clock, log)) for _ in range(2))
    clock.run_to(1)
    interrupt(first)
    kill(first)
    kill(second)
    interrupt(second)
    kill(second)
    clock.run_to(9)
    assert log == ["tidied", "tidied"]
    assert not first.is_alive and not second.is_alive and not clock.interrupted


def test_a_procedure_that_kills_itself_ends_where_it_waits():
    clock, log = Clock(), []

    def procedure():
        yield clock.timeout(1)
        kill(process)
        log.append("still there")
        yield clock.timeout(0)
        log.append("never")

    process = clock.process(procedure())
    clock.run_to(2)
    assert log == ["still there"] and not process.is_alive


def test_what_is_to_be_done_soon_comes_before_all_that_is_due():
    clock, log = Clock(), []
    clock.call_later(0, lambda: log.append("due"))
    clock.soon(lambda: log.append("soon"))
    clock.run_to(0)
    assert log == ["soon", "due"]


def test_a_procedure_may_skip_its_timeouts_and_everything_happens_in_the_same_order():
    def happenings(skips):
        clock, log = Clock(), []

        def ticks(name, period, skips):
            for _ in range(20):
                log.append((clock.now, name))
                if not (skips and clock.skip(period)):
                    yield clock.timeout(period)

        clock.process(ticks("a", 2, skips))
        clock.process(ticks("b", 5, False))
        for end in (7, 20, 21, 60, 200):
            clock.run_to(end)
            log.append((clock.now, "end"))
        return log, next(clock._eid)

    (log, events), (skipped, fewer) = happenings(False), happenings(True)
    assert skipped == log and fewer < events


def test_nothing_is_skipped_beyond_an_event_or_the_end_of_a_run():
    clock, log = Clock(), []

    def procedure():
        yield clock.timeout(1)
        log.extend((clock.free_ns, clock.skip(9), clock.skip(8), clock.now, clock.free_ns))

    clock.process(procedure())
    clock.call_later(10, lambda: None)
    clock.run_to(20)
    assert log == [9, False, True, 9, 1] and clock.now == 20


def test_nothing_is_skipped_while_the_clock_is_observed_or_stepped():
    clock, log = Clock(), []

    def procedure():
        while True:
            yield clock.timeout(10)
            log.append((clock.free_ns, clock.skip(1)))

    clock.process(procedure())
    clock.step()
    clock.step()
    end = clock.subscribe(lambda: None)
    clock.run_to(20)
    end()
    assert log == [(0, False), (0, False)]
    clock.run_to(35)
    assert log[2:] == [(5, True)]
