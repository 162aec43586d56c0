"""The numbers of the manual's examples; the fidelity report lists expected and obtained values."""

from itertools import pairwise

import pytest

from .scenarios import EXAMPLE, clock, points, position, start_host_mode, turn_to
from .talking import advance, ask, load, positions, send, value

FIGURE = {0: 0, 1000: 250, 2000: 500, 3000: 250, 4000: 0, 5000: 500, 6000: 1000, 7000: 750, 8000: 500, 9999: 500}
"""Figures 9.1 and 9.2: counts of the external encoder, and positions in the first cycle."""


@pytest.mark.parametrize(("f", "name"), [(128, "Figure 9.1"), (16, "Figure 9.2")])
def test_two_cycles_of_the_figures(bench, motor, printed, f, name):
    """Figures 9.1 and 9.2, "Two cycles shown": the examples have BASE 8000 and D 2000."""
    load(bench, motor, EXAMPLE.format(f=f"F={f}") + "END\n")
    send(bench, motor, "RUN", 0)
    bench.run(0.05)
    first = [turn_to(bench, motor, at) for at in FIGURE]
    second = [turn_to(bench, motor, 10_000 + at) for at in FIGURE]
    printed(name, "shaft at the counts 0, 1000, ... 8000, 9999", list(FIGURE.values()), first)
    printed(name, "the same in the second cycle", [500 + at for at in FIGURE.values()], second)


@pytest.mark.parametrize(("f", "goes_to"), [(0, 1), (16, 3001)])
def test_the_first_entry_from_3000(bench, motor, printed, f, goes_to):
    """9.4: "immediately attempt to move to 1, whereas if F=16, the motor would immediately attempt to move to 3001"."""
    send(bench, motor, f"MF4 F={f} BASE=8000 SIZE=8 D=0 O=3000 aw[0] 1 250 500 250 0 500 1000 750 500. MC G", 0)
    advance(bench, 3)
    printed(
        "9.4 Mode cam limitations", f"F={f}, at 3000, aw[0]=1: commanded position", goes_to, value(bench, motor, "@P")
    )


def test_strobed_records(bench, motor, printed):
    """10.1: "time delta 0x01 00", then "reduce time delta to 0x40": the positions at the times in the comments."""
    pairs = points((0, 0), (0x1000, 0x100)) + position(0x2000) + position(0x3000) + points((0x3400, 0x340))
    start_host_mode(bench, motor, "O=0 ", pairs + position(0x3800) + position(0x3C00) + position(0x4000))
    found = positions(bench, motor, 0x400)
    at = [0x100, 0x200, 0x300, 0x340, 0x380, 0x3C0, 0x400]
    expected = [0x1000, 0x2000, 0x3000, 0x3400, 0x3800, 0x3C00, 0x4000]
    printed("10.1 Automatic strobing", f"positions at the clocks {at}", expected, [found[n - 1] for n in at])


def test_constant_speed_after_host_mode(bench, motor, printed):
    """10.2: "RMODE returns V", "RV returns 262144"; "maintaining constant velocity each Sample" of 4 counts."""
    start_host_mode(bench, motor, "O=0 MV V=4*65536 A=100 ", points((0, 0), (0x400, 0x100)) + clock(0x100))
    found = positions(bench, motor, 600)
    printed("10.2 Orderly exit", "RMODE", "V", ask(bench, motor, "RMODE"))
    printed("10.2 Orderly exit", "RV", "262144", ask(bench, motor, "RV"))
    steps = {after - before for before, after in pairwise(found)}
    printed("10.2 Orderly exit", "counts in each sample, also after the host mode", [4], sorted(steps))


def test_servo_in_place_after_host_mode(bench, motor, printed):
    """10.2: "decelerate to a stop at acceleration A=2; then return to the final host mode position"."""
    start_host_mode(bench, motor, "O=0 MP A=2 V=10000 D=0 ", points((0, 0), (64, 256)) + clock(256))
    bench.run(20)
    printed("10.2 Orderly exit", "A=2, V=10000, D=0: where it servoes in the end", 64, motor.axes["shaft"].position)


def test_f_33_is_f_1_and_f_32(bench, motor, printed):
    """7.0: "if you want F=1 and F=32, issue command F=33"."""
    send(bench, motor, "F=33", 0)
    printed("7.0 F=", "F=32+1 and F=33: the word", 33, value(bench, motor, "F"))


def test_rsp_of_this_firmware(bench, motor, printed):
    """Front page: "24576/476": the sample period in units of 10 ns, and the firmware's number."""
    printed("Firmware version", "RSP", "24576/476", ask(bench, motor, "RSP"))
    send(bench, motor, "CLK=0", 0)
    advance(bench, 1000)
    printed("Firmware version", "1000 samples of 245,760 ns, by CLK", 1000, value(bench, motor, "CLK"), within=1)


def test_a_hundred_samples_are_forty_in_a_second(bench, motor, printed):
    """9.5, example 4: WAIT=100: "max length change of 40 per second of button pressing"."""
    load(bench, motor, "a=0\nWHILE 1\na=a+1\nWAIT=100\nLOOP\nEND\n")
    send(bench, motor, "RUN", 0)
    bench.run(10)
    printed("9.5, example 4", "rounds in 10 s of a loop with WAIT=100", 400, value(bench, motor, "a"), within=10)
