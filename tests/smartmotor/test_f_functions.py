"""Chapter 7: the bits of F, one by one and together."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .playing import play, scripts
from .talking import advance, ask, load, ready, send, steps, wired

CRUISE = "A=65536 V=65536*10 MV G"  # one count per sample², ten counts per sample
OPEN = "OCHN(RS4,1,N,9600,1,8,C)"


@pytest.fixture
def motor(bench: Bench) -> Controller:
    return wired(bench)


def f_of(bench: Bench, motor: Controller) -> int:
    return int(send(bench, motor, "x=F Rx", 0))


@scripts(
    {
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
    }
)  # fmt: skip
def test_f_functions(script):
    play(script)


# Bit 0: deceleration to a stop


@pytest.mark.parametrize("functions", [1, 33, 35 - 2])
def test_f_1_decelerates_to_a_stop_at_a_limit(bench, motor, functions):
    """7.1, F=1: "Upon a software or hard limit, the motor decelerates to a stop", here in 9+8+…+1 counts."""
    send(bench, motor, f"F={functions} {CRUISE}", 0)
    advance(bench, 50)
    motor.pins["C"].drive(True)
    found = steps(bench, motor, 20)
    assert found[:2].count(10) <= 2
    rest = [way for way in found if way != 10]
    assert rest[:10] == [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]
    assert not any(rest[10:])
    assert found.count(10) <= 1


def test_f_1_with_mtb_ends_in_mtb(bench, motor):
    """4.2, F=1: "With MTB enabled, the motor will decelerate to a stop and then switch to MTB"."""
    send(bench, motor, f"F=1 {CRUISE}", 0)
    advance(bench, 50)
    motor.pins["C"].drive(True)
    advance(bench, 5)
    assert ask(bench, motor, "RMODE", 0) != "B"
    advance(bench, 10)
    assert send(bench, motor, "RMODE RBt", 0) == b"B\r0\r"


def test_f_1_decelerates_at_the_newest_a(bench, motor):
    """3.2: "at the acceleration value set by "A"": A of two counts per sample² gives 8+6+4+2 counts."""
    send(bench, motor, f"F=1 {CRUISE}", 0)
    advance(bench, 50)
    send(bench, motor, "A=65536*2", 0)
    motor.pins["C"].drive(True)
    found = [way for way in steps(bench, motor, 20) if way != 10]
    assert found[:6] == [8, 6, 4, 2, 0, 0]


def test_f_0_turns_the_amplifier_off_at_a_limit(bench, motor):
    """7.1, F=0: at a limit an ideal shaft stops at once, Bo is 1, and MTB is active."""
    send(bench, motor, f"F=1 F=0 {CRUISE}", 0)
    advance(bench, 50)
    motor.pins["C"].drive(True)
    found = steps(bench, motor, 10)
    assert set(found) <= {10, 0}
    assert found.count(10) <= 1
    assert send(bench, motor, "RBo RMODE", 0) == b"1\rB\r"


# Bit 1: the direction of the shaft


@pytest.mark.parametrize("mode", ["MF4", "MS", "MFMUL=2 MFDIV=1 MFR G"])
def test_f_2_reverses_following(mode):
    """7.1, F=2: with the same movement of the master, the shaft turns in the opposite direction."""
    found = []
    for functions in (0, 2):
        bench = Bench()
        motor = wired(bench)
        send(bench, motor, f"F={functions} A=65536 V=65536*50 {mode}", 0.01)
        motor.master.move(400, 0.5)
        bench.run(1.0)
        found.append(motor.axes["shaft"].position)
    assert found[0] == -found[1] != 0


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
    assert abs(motor.axes["shaft"].position - at) <= 1
    assert send(bench, motor, "RBe RBo", 0) == b"0\r0\r"


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


# F=16 and F=128

CAM = "D=200 BASE=1000 SIZE=4 aw[0] 0 100 200 300 400."


def cam_after(functions: int, counts: int) -> tuple[int, int, int]:
    """Return shaft position, RP and CTR after a movement of the master."""
    bench = Bench()
    motor = ready(bench)
    send(bench, motor, f"MF4 F={functions} {CAM} O=0 MC G", 0.01)
    motor.master.move(counts, 1.0)
    bench.run(1.1)
    position, counter = send(bench, motor, "RP RCTR", 0).split()
    return motor.axes["shaft"].position, int(position), int(counter)


@pytest.mark.parametrize(("counts", "place"), [(500, 200), (1000, 400), (1100, 400), (1700, 600), (2500, 850 - 10)])
def test_f_16_each_cycle_begins_where_the_last_has_ended(counts, place):
    """7.1, F=16; 9.3: a cycle of 1000 counts and 200 of dwell moves by 400; 2500 counts are 2 cycles and 100."""
    assert cam_after(16, counts) == (place, place, counts)


def test_f_128_resets_position_and_counter_at_base_plus_dwell():
    """7.1, F=128: "set to zero at modulo "BASE" plus dwell "D""; 1700 is a cycle and 500, where the table is 200."""
    _, position, counter = cam_after(128, 1700)
    assert (position, counter) == (200, 500)


# Together, and nonsense


def test_f_35_is_1_2_and_32(bench, motor):
    """7.0: "F=35 activates F=1, F=2, and F=32 functions"."""
    load(bench, motor, f"F=35\n{CRUISE.replace(' ', chr(10))}\nWHILE 1\nLOOP\nEND\nC1\ni=i+1\nRETURNF\n")
    send(bench, motor, "RUN", 0)
    advance(bench, 60)
    assert steps(bench, motor, 3) == [-10, -10, -10]
    motor.pins["C"].drive(True)
    motor.pins["D"].drive(True)
    rest = [way for way in steps(bench, motor, 20) if way != -10]
    assert rest[:10] == [-9, -8, -7, -6, -5, -4, -3, -2, -1, 0]
    assert int(ask(bench, motor, "Ri", 0)) >= 1


@pytest.mark.parametrize("text", ["F=", "F=1.5", "F=(1", "F=x y", "F35", "F=2147483648", "F==1", "F=F/0"])
def test_an_invalid_value_of_f_changes_nothing(bench, motor, text):
    """7 and 8.1: F= without a valid expression sets a flag and returns nothing."""
    send(bench, motor, "F=9 ZS", 0)
    assert send(bench, motor, f"{text} ") == b""
    assert send(bench, motor, "a=Bs|Bd Ra") == b"1\r" or text == "F=x y"
    assert f_of(bench, motor) == (0 if text == "F=x y" else 9)


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
