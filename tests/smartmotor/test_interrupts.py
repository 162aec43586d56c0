"""Chapter 7: F=32 calls C1 at a fault, F=64 calls C2 at a falling edge of pin G."""

import pytest

from .scenarios import COUNTING, trigger
from .talking import advance, ask, load, ready, run, send, values, wired

# Calls of C1 and C2, and returns from C1 and C2


def test_each_falling_edge_of_g_calls_c2_once(bench, motor):
    """7.1, F=64: "when the I/O pin G goes from a high to low edge transition"; a low level alone calls nothing."""
    run(bench, motor, "F=64" + COUNTING)
    for count in range(1, 5):
        motor.pins["G"].drive(False)
        advance(bench, 200)
        assert values(bench, motor, "ij") == [0, count]
        motor.pins["G"].drive(True)
        advance(bench, 200)
        assert values(bench, motor, "ij") == [0, count]


def test_the_program_goes_on_where_it_was_interrupted(bench, motor):
    """7.1: RETURNI returns "to program pointer when the input was triggered"."""
    run(bench, motor, "F=64" + COUNTING)
    trigger(bench, motor)
    before = values(bench, motor, "m")[0]
    advance(bench, 300)
    assert values(bench, motor, "m")[0] == before + 100  # WHILE, m=m+1 and LOOP take three samples per pass


def test_without_f_64_an_edge_calls_nothing(bench):
    motor = wired(bench)
    run(bench, motor, "F=0" + COUNTING)
    trigger(bench, motor)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    assert values(bench, motor, "ij") == [0, 0]


def test_pin_g_low_already_when_f_64_is_given(bench, motor):
    """7.1: an edge calls C2; a pin that is already low when F=64 is given does not."""
    motor.pins["G"].drive(False)
    advance(bench, 50)
    run(bench, motor, "F=64" + COUNTING)
    assert values(bench, motor, "j") == [0]
    motor.pins["G"].drive(True)
    advance(bench, 50)
    trigger(bench, motor)
    assert values(bench, motor, "j") == [1]


@pytest.mark.parametrize("debounce", [1, 2, 5, 20])
def test_pin_g_is_polled_once_per_sample_and_debounced(bench, debounce):
    """7.1: a low level for the number of samples in option `debounce` is an edge; a shorter one is not."""
    motor = ready(bench, debounce_samples=debounce)
    run(bench, motor, "F=64" + COUNTING)
    if debounce > 1:
        trigger(bench, motor, low=debounce - 1, high=50)
        assert values(bench, motor, "j") == [0]
    trigger(bench, motor, low=debounce, high=50)
    assert values(bench, motor, "j") == [1]


def test_a_pulse_between_two_polls_is_not_seen(bench):
    """7.1: the pin is "polled once per sample", so a pulse between two polls is not detected."""
    motor = ready(bench, debounce_samples=1)
    run(bench, motor, "F=64" + COUNTING)
    bench.clock.run_to(bench.now + 10_000)
    motor.pins["G"].drive(False)
    bench.clock.run_to(bench.now + 200_000)
    motor.pins["G"].drive(True)
    advance(bench, 50)
    assert values(bench, motor, "j") == [0]


def test_a_bouncing_switch_calls_c2_once(bench):
    """7.1: the pin "is de-bounced": 15 changes, 100 µs apart, before it stays low, and 15 before it stays high.

    The switch bounces for less than seven samples; an edge requires eight equal samples.
    """
    motor = ready(bench, debounce_samples=8)
    run(bench, motor, "F=64" + COUNTING)
    for last in (False, True):
        for n in range(15):
            motor.pins["G"].drive(last if n % 2 == 0 else not last)
            bench.clock.run_to(bench.now + 100_000)
        advance(bench, 100)
    assert values(bench, motor, "j") == [1]


@pytest.mark.parametrize("names", ["C", "D"])
def test_a_limit_input_calls_c1_once_for_each_new_occurrence(bench, names):
    """1.2, F=32: "on a new occurrence of motor protection fault"; 7.1: when Bp or Bm "becomes active"."""
    motor = wired(bench)
    run(bench, motor, "F=32" + COUNTING)
    for count in (1, 2, 3):
        motor.pins[names].drive(True)
        advance(bench, 50)
        assert values(bench, motor, "ij") == [count, 0]
        motor.pins[names].drive(False)
        send(bench, motor, "ZS", 0)
        advance(bench, 50)
        assert values(bench, motor, "ij") == [count, 0]


def test_both_limits_one_after_the_other(bench):
    """7.1: first Bp and then Bm are two occurrences, so C1 is called twice."""
    motor = wired(bench)
    run(bench, motor, "F=32" + COUNTING)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    motor.pins["D"].drive(True)
    advance(bench, 50)
    assert values(bench, motor, "i") == [2]


def test_a_limit_that_is_active_already_calls_nothing(bench):
    """7.1: C1 is called when the limit "becomes active", not for a limit that already is."""
    motor = wired(bench)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    send(bench, motor, "UCI ZS UCP", 0)
    advance(bench, 50)
    assert ask(bench, motor, "RBp", 0) == "1"
    send(bench, motor, "UCI ZS", 0.01)
    load(bench, motor, f"{COUNTING.strip()}\n")
    send(bench, motor, "UCP", 0.01)
    send(bench, motor, "RUN", 0.01)
    send(bench, motor, "F=32", 0.01)
    assert values(bench, motor, "i") == [0]


def test_a_software_limit_calls_c1(bench):
    """7.1: C1 is called for limits "via software or hardware limits"."""
    motor = wired(bench)
    run(bench, motor, "F=32" + COUNTING)
    send(bench, motor, "SLN=-5000 SLP=100 SLE A=65536 V=65536 P=1000 G", 0)
    advance(bench, 90)
    assert values(bench, motor, "i") == [0]
    advance(bench, 30)
    assert values(bench, motor, "i") == [1]


@pytest.mark.parametrize("functions", [0, 32])
def test_a_position_error_calls_c1_or_ends_the_program(bench, motor, functions):
    """4.1: "End program execution, if F=32 is not issued.  If F=32 is issued, program goes to label C1"."""
    run(bench, motor, f"F={functions}{COUNTING}")
    send(bench, motor, "E=50 A=65536 V=65536*4 MV G", 0)
    motor.axes["shaft"].jam(True)
    advance(bench, 100)
    assert ask(bench, motor, "RBe", 0) == "1"
    before = values(bench, motor, "m")[0]
    advance(bench, 100)
    assert values(bench, motor, "i") == [functions // 32]
    assert (values(bench, motor, "m")[0] > before) is bool(functions)


def test_overheat_calls_c1(bench, motor):
    """7.1: Bh (overheat) calls C1."""
    run(bench, motor, "F=32" + COUNTING)
    send(bench, motor, "THD=100 TH=10", 0)
    advance(bench, 200)
    assert ask(bench, motor, "RBh", 0) == "1"
    assert values(bench, motor, "i") == [1]


def test_a_jammed_motor_overheats_and_calls_c1(bench):
    """7.1, Bh: "this is also RMS over-current"; here full torque on a shaft that cannot turn."""
    motor = ready(bench, shaft={"motor": "frame23"})
    run(bench, motor, "F=32\nMT\nT=1023" + COUNTING)
    motor.axes["shaft"].jam(True)
    assert any(send(bench, motor, "RBh", 0.1) == b"1\r" for _ in range(600))
    advance(bench, 20)
    assert values(bench, motor, "i") == [1]
    assert send(bench, motor, "RMODE RBo", 0) == b"B\r1\r"


def test_a_fault_in_c1_calls_c1_again_when_it_has_returned(bench):
    """1.2: "a new occurrence": if a limit opens while C1 handles a position error, C1 is called again afterwards."""
    motor = wired(bench)
    program = "F=32\nE=20\nA=65536\nV=65536\nMV\nG\nWHILE 1\nLOOP\nEND\nC1\ni=i+1\nWAIT=60\nj=j+1\nRETURNF\n"
    run(bench, motor, program)
    motor.axes["shaft"].jam(True)
    advance(bench, 30)
    motor.pins["C"].drive(True)
    advance(bench, 10)
    assert values(bench, motor, "ij") == [1, 0]
    advance(bench, 300)
    assert values(bench, motor, "ij") == [2, 2]


def test_c1_is_called_when_the_main_program_has_ended(bench):
    """RULINGS 17: after the main program of 4.3 has ended, a fault calls C1; the main program does not continue."""
    motor = wired(bench)
    load(bench, motor, "F=32\na=1\nEND\na=2\nC1\ni=i+1\nRETURNF\na=3\n")
    send(bench, motor, "RUN", 0.05)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    assert values(bench, motor, "ia") == [1, 1]
    motor.pins["C"].drive(False)
    send(bench, motor, "ZS", 0.01)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    assert values(bench, motor, "ia") == [2, 1]
