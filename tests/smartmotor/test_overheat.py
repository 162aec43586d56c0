"""The fault Bh: a controller too hot (TH, THD), or a current too large for too long; sections 2, 4 and 5.2."""

from itertools import pairwise

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, load, ready, send, tell

SAMPLE_NS = 245_760
UNIT = 65_536
BT, BI, BE, BH, BO, BX, BA = 1, 8, 32, 64, 128, 256, 16384
MOVE = f"A={UNIT} V={10 * UNIT} MV G"


def word(bench: Bench, motor: Controller) -> int:
    """RW without Bi, Bx and Ba: index mark and current limit are no matter of this chapter."""
    return int(ask(bench, motor, "RW")) & ~(BI + BX + BA)


def samples(bench: Bench, number: int) -> None:
    """To the end of so many samples from now."""
    bench.clock.run_to((bench.now // SAMPLE_NS + number) * SAMPLE_NS)


def temperature(bench: Bench, motor: Controller) -> int:
    return int(ask(bench, motor, "PRINT(TEMP,#13)"))


def heat(bench: Bench, motor: Controller, celsius: float = 71) -> None:
    """The air around an ideal motor, whose controller is as warm as that; THD=12000 samples are 2.95 s."""
    motor.ambient = celsius
    bench.run(3.1)


@pytest.mark.parametrize(("celsius", "trips"), [(25, False), (69, False), (70, False), (71, True), (120, True)])
def test_it_trips_above_th(bench, celsius, trips):
    """Table 4.1: "Controller temperature exceeded temperature limit"; TH is 70 at power-up."""
    motor = ready(bench)
    heat(bench, motor, celsius)
    assert temperature(bench, motor) == celsius
    assert word(bench, motor) == BO + trips * BH


def test_it_must_last_for_thd_samples(bench):
    """THD=12000 by default: 12000 samples are 2.949 s; a shorter heat is forgiven."""
    motor = ready(bench)
    motor.ambient = 75
    samples(bench, 11_950)
    motor.ambient = 25
    samples(bench, 100)
    motor.ambient = 75
    samples(bench, 11_950)
    assert word(bench, motor) == BO
    samples(bench, 100)
    assert word(bench, motor) == BO + BH


@pytest.mark.parametrize("thd", [1, 10, 1000])
def test_another_thd(bench, thd):
    """Within two samples of so many."""
    motor = ready(bench)
    motor.ambient = 75
    tell(bench, motor, f"THD={thd}", 0)
    begin = bench.now // SAMPLE_NS
    while motor.serial.read() != b"1\r":
        samples(bench, 1)
        motor.serial.write(b"RBh ")
        bench.clock.run_to(bench.now)
    assert thd - 1 <= bench.now // SAMPLE_NS - begin <= thd + 3


def test_the_sequence_of_an_overheat(bench):
    """4.1: amplifier off, MTB, static brake; nothing moves and nothing is obeyed, RUN and LOAD neither."""
    motor = ready(bench)
    load(bench, motor, "WHILE 1\na=a+1\nLOOP\n")
    tell(bench, motor, f"{MOVE} RUN", 0.1)
    heat(bench, motor)
    assert word(bench, motor) == BO + BH
    assert ask(bench, motor, "RMODE") == "B"
    assert motor.pins["brake"].level
    stood, counted = motor.axes["shaft"].position, ask(bench, motor, "Ra")
    assert send(bench, motor, b"LOAD ") == b""
    for command in ("G", "MT T=500", "X", "S", "MF4", "MS", "RUN"):
        tell(bench, motor, command, 0.05)
        assert motor.axes["shaft"].position == stood
        assert ask(bench, motor, "Ra") == counted
        assert motor.pins["brake"].level


@pytest.mark.parametrize(("f", "calls", "counts_on"), [(0, 0, False), (1, 0, False), (32, 1, True), (33, 1, True)])
def test_the_program_ends_or_goes_to_c1(bench, f, calls, counts_on):
    """4.1 item 4 of the motor protection fault."""
    motor = ready(bench)
    load(bench, motor, f"F={f}\nWHILE 1\na=a+1\nLOOP\nC1\nc=c+1\nRETURNF\n")
    tell(bench, motor, f"{MOVE} RUN", 0.1)
    heat(bench, motor)
    before = ask(bench, motor, "Ra")
    bench.run(0.1)
    assert ask(bench, motor, "Rc") == str(calls)
    assert (ask(bench, motor, "Ra") != before) is counts_on


def test_f_1_decelerates(bench):
    """4.1 item 1: "If F=1 is issued, the controller decelerates to a stop"; then MTB (table 4.2)."""
    motor = ready(bench)
    motor.ambient = 75
    tell(bench, motor, f"THD=100 F=1 {MOVE}", 0)
    path = []
    for _ in range(200):
        samples(bench, 1)
        path.append(motor.axes["shaft"].position)
    path = path[: path.index(path[-1]) + 2]
    steps = [later - earlier for earlier, later in pairwise(path)]
    assert steps[-11:] == [10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0]
    samples(bench, 2)
    assert word(bench, motor) == BO + BH


@pytest.mark.parametrize("clear", ["Zh", "ZS"])
def test_it_is_cleared_when_it_has_cooled_by_5_degrees(bench, clear):
    """Reference 10: "Motion refused until cooled 5 °C below TH": 66 is too warm; it never clears by itself."""
    motor = ready(bench)
    heat(bench, motor)
    tell(bench, motor, "P=50 A=65536 V=65536 MP")
    for celsius in (71, 70, 66):
        motor.ambient = celsius
        bench.run(1.0)
        tell(bench, motor, f"{clear} G", 0.1)
        assert word(bench, motor) == BO + BH
        assert motor.axes["shaft"].position == 0
    motor.ambient = 65
    bench.run(1.0)
    assert word(bench, motor) == BO + BH
    tell(bench, motor, "Ze Zr Zl G", 0.1)
    assert word(bench, motor) == BO + BH
    tell(bench, motor, f"{clear} G", 0.1)
    assert word(bench, motor) == 0
    assert motor.axes["shaft"].position == 50


def test_a_winding_warms_slowly(bench):
    """A frame 23 in hot air: not at once, in the end; and a power cycle forgets the flag but not the heat.

    Its housing is as warm as the air after minutes instead of hours.
    """
    motor = ready(bench, shaft={"motor": {"model": "frame23", "housing_time_constant_s": 60.0}})
    motor.ambient = 100
    bench.run(10)
    assert word(bench, motor) == BO
    bench.run(12 * 60)
    assert word(bench, motor) == BO + BH
    assert temperature(bench, motor) > 90
    motor.power_cycle()
    tell(bench, motor, "UCI UDI ZS", 0.5)
    assert word(bench, motor) == BO
    assert temperature(bench, motor) > 90
    bench.run(3.0)
    assert word(bench, motor) == BO + BH


def test_too_much_current_for_too_long(bench):
    """Table 4.1: "RMS current exceeded limit": a jammed motor that pushes, while its controller is still cool.

    The position error is allowed to be 32000.  Then Zh is refused for a while; afterwards the motor moves again.
    """
    motor = ready(bench, shaft={"motor": "frame23"})
    motor.axes["shaft"].jam(True)
    tell(bench, motor, "E=32000 A=200 V=400000 P=500 G", 1.0)
    assert word(bench, motor) == 0
    assert bench.run_until(lambda: motor.pins["brake"].level, 9.0)
    tell(bench, motor, "Zh")
    assert word(bench, motor) == BO + BH
    assert temperature(bench, motor) < 40
    motor.axes["shaft"].jam(False)
    tell(bench, motor, "Zh G", 0.1)
    assert word(bench, motor) == BO + BH
    bench.run(120.0)
    assert word(bench, motor) == BO + BH
    tell(bench, motor, "Zh G", 2.0)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (0, "500")


def test_a_held_load_that_the_motor_can_bear_never_trips(bench):
    """An hour at a tenth of a newton metre."""
    motor = ready(bench, shaft={"motor": "frame23"})
    tell(bench, motor, "P=0 A=200 V=20000 G")
    motor.axes["shaft"].load(0.1)
    bench.run(600.0)
    assert word(bench, motor) == 0
    assert abs(int(ask(bench, motor, "RP"))) < 5


def test_overheat_and_position_error_together(bench):
    """Two flags, each with its own Z; one is not enough."""
    motor = ready(bench)
    heat(bench, motor, 69)
    tell(bench, motor, MOVE, 0.1)
    motor.axes["shaft"].jam(True)
    samples(bench, 110)
    motor.axes["shaft"].jam(False)
    heat(bench, motor)
    assert word(bench, motor) == BO + BH + BE
    heat(bench, motor, 20)
    tell(bench, motor, "Zh G", 0.1)
    assert word(bench, motor) == BO + BE
    tell(bench, motor, "Ze G", 0.1)
    assert word(bench, motor) == BT


def test_th_below_the_temperature(bench):
    """TH=20 in a room of 25 °C is an overheat after THD samples."""
    motor = ready(bench)
    tell(bench, motor, "TH=20", 3.1)
    assert word(bench, motor) == BO + BH
    tell(bench, motor, "TH=29 Zh")
    assert word(bench, motor) == BO + BH
    tell(bench, motor, "TH=30 Zh")
    assert word(bench, motor) == BO
