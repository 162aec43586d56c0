"""9.5: changes of cam parameters during a cam, and the commands that make a CI invalid."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .scenarios import cam, start_cam, turn_to
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, load, ready, send, value

OLD = "turn 11000 12000 18000 18100 20000 21000: 750 1000 1000 1000 1000 1250"


@pytest.fixture
def motor(bench: Bench) -> Controller:
    """Return a motor with the cam of example 2, at 3000 counts in the first cycle."""
    motor = ready(bench)
    start_cam(bench, motor)
    turn_to(bench, motor, 3000)
    return motor


# The programs


EXAMPLE_4 = """F=144
BASE=2000
D=100
MC2
G
BASE=10000
D=107525
MC2
CI
UAI
UBI
WHILE 1
IF UAI
D=D+1
MC2
CI
ENDIF
IF UBI
D=D-1
MC2
CI
ENDIF
WAIT=100
LOOP
END
"""


@scripts({
    # Dwell
    '9.2: "First send the new dwell value and issue "CI" which initializes the new dwell value the next time '
    'the "zero" point, end of base plus dwell or aw[0], is passed": the dwell is still 2000 in this cycle, '
    "100 in the next":
    f"{cam()}; turn 3000; D=100 CI; turn 9999 10000 18000 18100 19100: 500 500 1000 1000 1250; CX is 1",
    '9.3: "crosses the zero-point boundary (between 0 and BASE plus dwell) in either direction"':
    f"{cam()}; turn 3000; D=100 CI; turn 0 -100 -1100 -8100 -8200 -9200: 0 0 250 -500 -500 -250",
    "9.2: in cam modulo a new dwell is used from the next zero point too":
    f"{cam('F=128')}; turn 3000; D=100 CI; turn 9999; RCTR -> 9999; turn 18099; RCTR RP -> 8099 500; "
    "turn 18100; RCTR RP -> 0 0",
    '9.1: "Dwell can be set to zero"':
    f"{cam()}; turn 3000; D=0 CI; turn 10000 18000 19000: 500 1000 1250; D=50 CI; "
    "turn 26000 34000 34050 35050: 1500 2000 2000 2250",
    # BASE, SIZE, MCn
    '9.5: "Send the new values of BASE and/or SIZE ... followed by the MCn and CI command"':
    f"{cam()}; turn 3000; BASE=4000 MC CI; "
    "turn 8000 10000 10500 13000 14000 16000 16500: 500 500 750 1500 1000 1000 1250",
    'Option cam_multiplier="table": CI puts MC2 in force as twice the distance':
    f"with cam_multiplier=table; {cam()}; turn 3000; MC2 CI; "
    "turn 8000 10000 11000 16000 18000 20000 21000: 500 500 1000 2500 1500 1500 2000",
    'Example 5: "BASE=1 will have no effect until next MCn command"; G uses the BASE that MC2 has taken':
    "MF4 aw[0] 0 10 20 30 40 50 60 70 80 90 100. F=144 BASE=10000 SIZE=10 D=0 MC2 BASE=1 G; "
    "turn 500 2500 4999 5000 7500: 10 50 99 100 150",
    # What invalidates a CI
    "9.5: only D, BASE, SIZE, MCn and changes of the bits 16 and 128 of F invalidate CI":
    [f"{cam()}; turn 3000; D=100 CI {words} -> *; turn 10000 18000 18100 19100: 500 1000 1000 1250"
     for words in (
         "F=16 ", "F=24 ", "F=17 ", "V=5 A=7 P=3 E=900 ", "aw[20]=5 ", "RP x=CX RCTR ", "CI ",
     )],
    '9.5: "A new MCn and CI command must be issued"':
    f"{cam()}; turn 3000; BASE=4000 MC CI D=0; turn 7000; MC CI; turn 10000 10500 14000 14500: 500 750 1000 1250",
    "CI has effect at one crossing only: a later D needs another CI":
    f"{cam()}; turn 3000; D=100 CI; turn 10001; D=700; turn 18100 19100 26200 27200: 1000 1250 1500 1750",
    # F=16 and F=128 on the fly
    '9.5: "will not take effect in cam mode, even though the change has been made in F, until the CI command '
    'is issued and there is a zero-point crossing"':
    f"{cam()}; turn 3000; F=144; turn 11000; RCTR RP -> 11000 750; CI; turn 25000; turn 30500; "
    "RCTR RP -> 500 125; at 1625",
    '9.4: without F=16 "absolute positioning would take immediate effect"; with CI at the zero point (9.5)':
    f"{cam()}; turn 3000; F=0 MC CI; turn 9000 10000 11000 16000 17000 18000 19000: 500 0 250 1000 750 0 250",
    "f 128 withdrawn lets the counter go on":
    f"{cam('F=144')}; turn 3000; F=16; turn 10500; RCTR -> 500; CI; turn 40500; CTR > 10000; at 2125",
    # The programs
    "9.5, example 4: MC2 halves BASE and D: 2000 and 100 take 1050 counts, 10000 take 5000, 107525 take "
    "53762.5":
    f"A low; B low; load {EXAMPLE_4}; MF4 SIZE=10 aw[0] 0 100 200 300 400 500 600 700 800 900 1000. RUN; 0.1 s; "
    "RMODE RBs -> C 0; "
    "turn 500 1000 1049 1050 3550 6050 59812 59813 62313 by 100: 500 1000 1000 1000 1500 2000 2000 2000 2500",
    # 9.3: a dwell that changes only at the boundary prevents abrupt moves
    "9.2, 9.3: without CI the dwell stays, and CI takes nothing that has not been changed":
    [f"{cam()}; turn 3000; {words}; {OLD}" for words in ("D=100", "CI")],
    "9.3: if the boundary is never crossed the dwell never changes":
    f"{cam()}; turn 3000; D=0 CI; turn 9999 1 8000 5000 9998 1000: 500 0 500 500 500 250",
    "9.5: SIZE=4 MC CI: the first four intervals extend over all of BASE; the last position is aw[4]=0":
    f"{cam()}; turn 3000; SIZE=4 MC CI; turn 10000 12000 14000 18000 20000 22000: 500 750 1000 500 500 750",
    "9.5: from the next zero point MC2 passes BASE in 4000 counts and D in 1000":
    f"{cam()}; turn 3000; MC2 CI; turn 8000 10000 11000 14000 15000 15500: 500 500 1000 1000 1000 1250",
    "9.5: neither the BASE sent before CI nor the D sent after CI takes effect":
    f"{cam()}; turn 3000; BASE=4000 MC CI D=0; {OLD}",
    "After a second crossing, backwards, the new dwell stays and no other parameter changes":
    f"{cam()}; turn 3000; D=100 CI; turn 10500 10000 9900 8900: 625 500 500 750",
    '9.5: "The MCn command causes the buffered cam interval length BASE/SIZE to be calculated"':
    [f"{cam()}; turn 3000; {words}; {OLD}"
     for words in ("BASE=4000", "BASE=4000 CI", "SIZE=4 CI", "BASE=4000 MC", "MC2", "MC8 D=1")],
    '9.5: "The issuance of any of the commands D, BASE, SIZE, MCn, or changing F=16 or 128, after the CI command, '
    'but before the next zero point crossing occurs, will invalidate the CI command"':
    [f"{cam()}; turn 3000; D=100 CI; turn 5000; {words}; {OLD}"
     for words in (
         "D=300", "D=100", "BASE=4000", "BASE=8000", "SIZE=8", "MC", "MC2", "F=144", "F=128", "F=0", "F=144 F=16",
         "F=0 F=16",
     )],
})  # fmt: skip
def test_cam_on_the_fly(script):
    play(script)


def button_program(bench, program):
    """Return a motor with a table from 0 to 1000, pins A and B low, and the program running."""
    motor = ready(bench)
    for pin in "AB":
        motor.pins[pin].drive(False)
    load(bench, motor, program)
    send(bench, motor, "MF4 SIZE=10 aw[0] 0 100 200 300 400 500 600 700 800 900 1000. RUN", 0)
    bench.run(0.1)
    assert send(bench, motor, "RMODE RBs", 0) == b"C\r0\r"
    return motor


@pytest.mark.parametrize(("pin", "sign"), [("A", 1), ("B", -1)])
def test_example_4_a_button_changes_the_dwell_by_1_every_100_samples(bench, pin, sign):
    """Example 4: "max length change of 40 per second of button pressing"; D is the buffered value."""
    motor = button_program(bench, EXAMPLE_4)
    motor.pins[pin].drive(True)
    bench.run(1.0)
    motor.pins[pin].drive(False)
    bench.run(0.1)
    steps = (value(bench, motor, "D") - 107_525) * sign
    assert 36 <= steps <= 40  # 4069 samples a second; some statements besides WAIT


EXAMPLE_5 = """b=10000
F=144
BASE=b
SIZE=10
D=0
MC2
BASE=1
G
WHILE 1
IF UAI
b=b+10
ENDIF
IF UBI
b=b-10
ENDIF
BASE=b
MC2
CI
WAIT=4000
LOOP
END
"""


def test_example_5_stretches_the_base_at_the_next_zero_point(bench):
    """9.5, example 5: three passes with button A make BASE 10030, an interval of 1003; MC2 halves BASE to 5015."""
    motor = button_program(bench, EXAMPLE_5)
    turn_to(bench, motor, 500)
    motor.pins["A"].drive(True)
    bench.clock.run_to(bench.now + 12_500 * SAMPLE_NS)  # a pass takes 4000 samples and the samples of its statements
    motor.pins["A"].drive(False)
    bench.run(1.5)
    assert value(bench, motor, "b") == value(bench, motor, "BASE") == 10_030
    bench.run(0.2)
    before = turn_to(bench, motor, 5000)
    assert turn_to(bench, motor, 10_015) - before == 1000 and value(bench, motor, "CX") == 0


# Beyond


def test_a_power_cut_forgets_a_pending_ci_and_the_cam(bench, motor):
    """16: a power cut clears the cam and a pending CI; only the program is kept."""
    send(bench, motor, "D=100 CI", 0)
    motor.power_cycle()
    bench.run(0.5)
    assert send(bench, motor, "RMODE a=CX Ra RBASE RCTR Raw[1]", 0).startswith(b"B\r0\r")
    assert value(bench, motor, "aw[1]") == value(bench, motor, "D") == value(bench, motor, "CTR") == 0


def test_a_fault_in_the_cam_stops_following(bench, motor):
    """3.2, 4.1: pin C becomes a limit again while it is open: the cam stops until the fault is cleared."""
    send(bench, motor, "UCP", 0)
    bench.run(0.05)
    here = turn_to(bench, motor, 6000)
    assert send(bench, motor, "RBr RBo RMODE G RMODE", 0) == b"1\r1\rB\rB\r"
    assert turn_to(bench, motor, 7000) == here == 250


CHANGES = st.lists(
    st.sampled_from(
        ["D=0", "D=50", "D=3000", "BASE=8", "BASE=4000", "BASE=0", "SIZE=4", "SIZE=101", "SIZE=0", "MC", "MC2",
         "MC8", "CI", "F=0", "F=16", "F=128", "F=144", "G", "X", "S"]
    ),
    max_size=15,
)  # fmt: skip


@settings(deadline=None, max_examples=15)
@given(changes=CHANGES, way=st.integers(-20_000, 20_000))
def test_any_order_of_changes_leaves_the_motor_operable(changes, way):
    """After any commands while the master turns, the motor answers, and a run in pieces gives the same result."""
    assert walk(changes, way, pieces=1) == walk(changes, way, pieces=7)


def walk(changes, way, pieces):
    bench = Bench()
    motor = ready(bench)
    start_cam(bench, motor)
    motor.master.move(way, 400 * SAMPLE_NS / 1e9)
    found = []
    for word in changes:
        send(bench, motor, word + "", 0)
        for _ in range(pieces):
            bench.clock.run_to(bench.now + 21 * SAMPLE_NS // pieces)
        found.append(motor.axes["shaft"].position)
    advance(bench, 2)
    found.append(send(bench, motor, "RP RCTR RMODE", 0))
    assert found[-1].count(b"\r") == 3
    return found
