"""Default values: what the interface sets up when the power is applied."""

import pytest

from axistwin.core.units import MS
from axistwin.sim.frames import LineError

from ..scripts import scripts
from .talking import arrivals, initialise, play, ready


@scripts({
    'Default values: "Speed range - 1 (0 - 25,000 steps/sec)"': "@25000; 0.1 s; F: 0; @25001; 0.1 s; F: 16",
    'Default values: "Index Length - 0 steps": done at once, without a pulse': "X$; 0.02 s; at 0 0 0; K: 0; E: C",
    'Default values: "Backlash correction - 0 steps", whichever way the index goes':
    "X100B$; idle; X-100B$; idle; X moves 100 -100",
    'Default values: "All Direction O/P - High"; "the positive direction is assumed"': "XYZ10$; idle; at 10 10 10",
    'Default values: "Speed - 400 steps/second"; the start/stop speed is 400 too, so there is no ramp':
    "X100$; idle; X 100 pulses at 400",
    'Default values: "Speed - 400 steps/second", exactly: in range 4 the resolution is 1 step/s':
    ">4; 1.2 s; X100$; idle; X 100 pulses at 400",
    # levels 400, 500 ... 900 of 100/10000 s = 10 ms each: 39 steps; 922 steps at 1000/s
    'Default values: "Acceleration - 10,000 steps/sec2", "Start/Stop - 400 steps/sec"':
    "X1000@1000$; idle; X 1000 pulses from 400 to 1000 by 100 at 10000",
    'Default values: "Outputs 1-5 - Off (reset)": the first pulse of an output therefore turns it on':
    "outputs 00000; P1,1$; P2,1$; P3,1$; P4,1$; P5,1$; 0.5 s; output1 high for 10 ms; output2 high for 10 ms; "
    "output3 high for 10 ms; output4 high for 10 ms; output5 high for 10 ms; outputs 00000",
    'Default values: "Pulse output - 10 (100mS)"': "P4$; idle; output4 high for 100 ms",
})  # fmt: skip
def test_defaults(bench, if1, script):
    play(bench, if1, script)


def test_inter_character_delay_0(bench, if1):
    """Default values: "Inter-char. delay - 0 mS": the characters of a reply follow one another."""
    characters = arrivals(bench, if1)
    play(bench, if1, "I: 200")
    first, second, *_ = (at_ns for at_ns, _, _ in characters)
    assert second - first < 2 * 11 * 1_000 * MS // 9600


def test_the_data_format_before_it_is_set(bench):
    """Default values: "8 bits, 2 stop bits with bit 8 = 0; no parity, no echo-back"."""
    if1 = bench.add("if1", line="1200 8N2")
    characters = arrivals(bench, if1)
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.2)
    assert [byte for _, byte, _ in characters] == [0x55, 0x0D]  # no `(` before it, so no echo
    assert all(errors is LineError.NONE for _, _, errors in characters)
    assert characters[1][0] - characters[0][0] >= 11 * 1_000 * MS // 1200  # start bit, 8 bits, 2 stop bits


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_without_the_lock_everything_is_back_to_default_after_power_off(bench, model):
    """Default values: "When the power is applied to the interface, it sets up sensible default values"."""
    card = ready(bench, model=model)
    # with D5, an answer of three characters takes 150 ms
    play(bench, card, ">3 <8 ^20; 1.2 s; B-20; D5; X50@1000S1$; P1,30$; 2 s; :Y10:$; 1 s; N; 0.5 s; receives 10<CR>")
    card.power_cycle()
    play(bench, card, "outputs 00000")
    initialise(bench, card)
    play(bench, card, "X$; :$; Y$; 1 s; at 50 10 0; Z1000B@1000$; idle; "
         "Z moves 1000; Z 1000 pulses from 400 to 1000 by 100 at 10000; P1$; idle; output1 high for 100 ms; "
         "O: 0; N: 1000")  # fmt: skip
