"""Virtual time in integer nanoseconds."""

from axistwin.sim.clock import Clock, kill


def test_time_is_an_integer_and_stands_at_the_end_of_a_run():
    clock = Clock()
    clock.run_to(7)
    clock.run_to(7)
    assert clock.now == 7
    assert type(clock.now) is int


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
    look_away = clock.look_on(lambda: seen.append((clock.now, len(state))))
    clock.run_to(7)
    state.append("by hand")
    clock.run_to(9)
    assert seen == [(0, 0), (3, 2), (5, 3), (7, 4)]
    look_away()
    clock.call_later(1, lambda: None)
    clock.run_to(20)
    assert len(seen) == 4
    assert "step" not in vars(clock)
