"""Chapter 7: the bits of F, one by one and together."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .scripts import play, scripts
from .talking import advance, ask, ready, send, wired

CRUISE = "A=65536 V=65536*10 MV G"  # one count per sample², ten counts per sample
CAM = "D=200 BASE=1000 SIZE=4 aw[0] 0 100 200 300 400."
OPEN = "OCHN(RS4,1,N,9600,1,8,C)"


@pytest.fixture
def motor(bench: Bench) -> Controller:
    return wired(bench)


@scripts({
    '7.0: "Upon power up F=0 is the default state", and again after a power cut':
    "wired; F is 0; F=255; power off; 0.1 s; power on; clear; F is 0",
    "7.0: F is the sum of the functions' values, e.g. F=33 (4.3), F=144 (9.5), F&191 (7.1)":
    [f"wired; F={value}; F is {value}; F=F&191; F is {value & 191}; RBs -> 0"
     for value in (0, 1, 2, 4, 8, 16, 32, 33, 35, 64, 96, 128, 144, 191, 255)],
    "13 of the base language: F without an equal sign puts the tuning in force and leaves the functions "
    "unchanged":
    "wired; F=35 KP=100 F; F is 35",
    # Bit 0: deceleration to a stop
    '7.1, F=1: "Bo will equal 0"':
    f"wired; F=1 {CRUISE}; 50 samples; C high; 5 samples; RBo RBr RBp -> 0 1 1",
    '4.2, F=1: "With MTB disabled the motor will decelerate to a stop and hold position"':
    f"wired; BRKRLS OFF F=1 {CRUISE}; 50 samples; C high; 30 samples; RBt RBo -> 0 0; mark; push 30; "
    "30 samples; moved 0",
    "7.1: positions 55, 65, …, 105 pass the soft limit 100; with F=1 the stop takes 9+8+…+1 = 45 counts more":
    [f"wired; F={functions} SLP=100 SLN=-100 SLE {CRUISE}; 100 samples; at {end}; RBr RBl -> 1 0"
     for functions, end in ((0, 105), (1, 150))],
    # Bit 1: the direction of the shaft
    '7.1, F=2: "will take effect at the moment the second bit of F is set"':
    f"wired; {CRUISE}; 50 samples; F=2; 20 steps of -10; F=34; 5 steps of -10; F=32; 20 steps of 10",
    '7.1, F=2: "in the opposite direction for any given mode"; positions are reported as commanded':
    "wired; F=2 A=65536 V=65536*10 P=300 G; 100 samples; at -300; RP RPE -> 300 0; D=-500 G; 100 samples; "
    "at 200",
    # Bit 2: channel 1
    '7.1, F=4: "Directs user program prints and report command to channel 1"':
    f"wired; {OPEN}; "
    'load PRINT("a",#13) / RP / F=4 / PRINT("b",#13) / RP / RUA / F=0 / PRINT("c",#13) / RF=1 / END; '
    "RUN -> a 0 c in 0.3 s; 485 receives b<CR>0<CR>1<CR>",
    "7.1, F=4: only a *program's* output goes to channel 1; a host receives answers on its own channel (6.2)":
    f"wired; {OPEN} F=4; RP -> 0; 485 writes RP<CR>; 0.1 s; 485 receives 0<CR>",
    # Bit 0: deceleration to a stop
    '7.1, F=1: "Upon a software or hard limit, the motor decelerates to a stop", here in 9+8+…+1 counts':
    [f"wired; F={functions} {CRUISE}; 50 samples; C high; steps 10 9 8 7 6 5 4 3 2 1 0; 9 steps of 0"
     for functions in (1, 33)],
    '4.2, F=1: "With MTB enabled, the motor will decelerate to a stop and then switch to MTB"':
    f"wired; F=1 {CRUISE}; 50 samples; C high; 5 samples; RMODE -> V; 10 samples; RMODE RBt -> B 0",
    '3.2: "at the acceleration value set by "A"": A of two counts per sample² gives 8+6+4+2 counts':
    f"wired; F=1 {CRUISE}; 50 samples; A=65536*2; C high; steps 10 8 6 4 2 0 0",
    "7.1, F=0: at a limit an ideal shaft stops at once, Bo is 1, and MTB is active":
    f"wired; F=1 F=0 {CRUISE}; 50 samples; C high; steps 10 0; 8 steps of 0; RBo RMODE -> 1 B",
    # Bit 1: the direction of the shaft
    "7.1, F=2: with the same movement of the master, the shaft turns in the opposite direction":
    [f"wired; F={functions} A=65536 V=65536*50 {mode}; 0.01 s; master 400 in 0.5 s; 1 s; at {way * counts}"
     for mode, counts in (("MF4", 400), ("MS", 400), ("MFMUL=2 MFDIV=1 MFR G", 800))
     for functions, way in ((0, 1), (2, -1))],
    # F=16 and F=128
    "7.1, F=16; 9.3: a cycle of 1000 counts and 200 of dwell moves by 400; 2500 counts are 2 cycles and 100":
    [f"MF4 F=16 {CAM} O=0 MC G; 0.01 s; master {counts} in 1 s; 1.1 s; at {place}; RP RCTR -> {place} {counts}"
     for counts, place in ((500, 200), (1000, 400), (1100, 400), (1700, 600), (2500, 840))],
    '7.1, F=128: "set to zero at modulo "BASE" plus dwell "D""; 1700 is a cycle and 500, where the table is 200':
    f"MF4 F=128 {CAM} O=0 MC G; 0.01 s; master 1700 in 1 s; 1.1 s; RP RCTR -> 200 500",
    # Together, and nonsense
    '7.0: "F=35 activates F=1, F=2, and F=32 functions"':
    f"wired; load F=35 / {CRUISE} / WHILE 1 / LOOP / END / C1 / i=i+1 / RETURNF; RUN; 60 samples; 3 steps of -10; "
    "C high; D high; steps -10 -9 -8 -7 -6 -5 -4 -3 -2 -1 0; i > 0",
    "7 and 8.1: F= without a valid expression sets a flag and returns nothing":
    [f"wired; F=9 ZS; {text}; a=Bs|Bd Ra -> 1; F is {0 if text == 'F=x y' else 9}"
     for text in ("F=", "F=1.5", "F=(1", "F=x y", "F35", "F=2147483648", "F==1", "F=F/0")],
})  # fmt: skip
def test_f_functions(script):
    play(script)


# Bit 1: the direction of the shaft


def test_f_2_reverses_torque_mode(bench):
    """7.1, F=2: "including Mode Torque", with a real motor, at the same speed in the other direction."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "MT T=300", 1.0)
    speed = motor.axes["shaft"].velocity
    assert speed > 0
    send(bench, motor, "F=2", 1.0)
    assert motor.axes["shaft"].velocity == -speed
    send(bench, motor, "F=0", 1.0)
    assert motor.axes["shaft"].velocity == speed


@pytest.mark.parametrize("functions", ["F=2 F=0", "F=2 F=2 F=2 F=0", "F=0", "F=255 F=0", "F=F|2 F=F&253"])
def test_f_2_and_back_leaves_a_resting_motor_where_it_is(bench, functions):
    """F=2 reverses later motion only; position and position error of a resting motor do not change."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "A=500 V=100000 P=2000 G", 1.0)
    at = motor.axes["shaft"].position
    send(bench, motor, functions, 0.2)
    assert abs(motor.axes["shaft"].position - at) <= 1 and send(bench, motor, "RBe RBo", 0) == b"0\r0\r"


# Bit 3: the integral term


def largest_error_after_the_end(functions: int) -> int:
    """Return the largest error after a move that ends under a constant torque, held by the integral term."""
    bench = Bench()
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, f"F={functions} KI=100 KL=20000 F A=500 V=100000 P=0 G", 0.2)
    motor.axes["shaft"].load(-0.2)
    bench.run(1.0)
    send(bench, motor, "P=1000 G", 0)
    assert bench.run_until(lambda: ask(bench, motor, "RBt", 0) == "0", 5)
    found = []
    for _ in range(500):
        advance(bench, 1)
        found.append(abs(int(ask(bench, motor, "RPE", 0))))
    assert found[-1] <= 1
    return max(found)


def test_f_8_clears_the_integral_at_the_end_of_a_trajectory():
    """7.1, F=8: without the integral term the torque displaces the shaft until the term has built up again."""
    assert largest_error_after_the_end(8) > largest_error_after_the_end(0) + 4


# Together, and nonsense


@settings(deadline=None, max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.lists(st.integers(-300, 300) | st.integers(-(2**31), 2**31 - 1), min_size=1, max_size=20))
def test_any_values_while_moving(values):
    """Any sum of bits is accepted at any time; the motor answers, and a repeated run gives the same result."""

    def course() -> tuple[bytes, int]:
        bench = Bench()
        motor = wired(bench)
        send(bench, motor, CRUISE, 0.01)
        for value in values:
            send(bench, motor, f"F={value}", 0.002)
        return send(bench, motor, "RP RW RBo a=F Ra"), motor.axes["shaft"].position

    first = course()
    last = int(first[0].split()[-1])
    allowed = [value for value in values if 0 <= value <= 255] or [0]
    assert first[0].count(b"\r") == 4
    assert last == allowed[-1] or not 0 <= values[-1] <= 255
    assert course() == first
