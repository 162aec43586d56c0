"""Default values: what the interface sets up when the power is applied."""

import pytest

from axistwin.sim import LineError
from axistwin.units import MS

from .talking import (
    arrivals,
    ask,
    command,
    constant,
    edges,
    initialise,
    moves,
    number,
    play,
    positions,
    pulse_times_of,
    ramped,
    ready,
    scripts,
    since_start,
    until_idle,
    write,
)


@scripts(
    {
        'Default values: "Speed range - 1 (0 - 25,000 steps/sec)"': "@25000; 0.1 s; F: 0; @25001; 0.1 s; F: 16",
        'Default values: "Index Length - 0 steps": done at once, without a pulse': "X$; 0.02 s; at 0 0 0; K: 0; E: C",
        'Default values: "Backlash correction - 0 steps", whichever way the index goes':
        "X100B$; idle; X-100B$; idle; X moves 100 -100",
        'Default values: "All Direction O/P - High"; "the positive direction is assumed"': "XYZ10$; idle; at 10 10 10",
    }
)  # fmt: skip
def test_defaults(bench, if1, script):
    play(bench, if1, script)


def test_speed_400(bench, if1):
    """Default values: "Speed - 400 steps/second"; the start/stop speed is 400 too, so there is no ramp."""
    write(if1, "X100$")
    until_idle(bench, if1)
    assert since_start(if1.axes["X"]) == constant(400, 100)


def test_acceleration_10000_and_start_stop_400(bench, if1):
    """Default values: "Acceleration - 10,000 steps/sec2", "Start/Stop - 400 steps/sec"."""
    write(if1, "X1000@1000$")
    until_idle(bench, if1)
    # levels 400, 500 ... 900 of 100/10000 s = 10 ms each: 39 steps; 922 steps at 1000/s
    course = ramped(1000, 400, 1000, 100, 10_000)
    assert [rate for rate, _ in course] == [400, 500, 600, 700, 800, 900, 1000, 900, 800, 700, 600, 500, 400]
    assert since_start(if1.axes["X"]) == pulse_times_of(course)
    assert since_start(if1.axes["X"])[-1] == (60 + 922 + 60) * MS


def test_outputs_off(bench, if1):
    """Default values: "Outputs 1-5 - Off (reset)": the first pulse of an output therefore turns it on."""
    for n in range(1, 6):
        output = if1.pins[f"output{n}"]
        assert not output.level
        seen = edges(output)
        command(bench, if1, f"P{n},1$", seconds=0.1)
        assert [level for _, level in seen] == [True, False]


def test_pulse_output_100_ms(bench, if1):
    """Default values: "Pulse output - 10 (100mS)"."""
    seen = edges(if1.pins["output4"])
    write(if1, "P4$")
    until_idle(bench, if1)
    assert seen[1][0] - seen[0][0] == 100 * MS


def test_inter_character_delay_0(bench, if1):
    """Default values: "Inter-char. delay - 0 mS": the characters of a reply follow one another."""
    characters = arrivals(bench, if1)
    ask(bench, if1, "I")
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
    command(bench, card, ">3 <8 ^20", seconds=1.2)
    for text in ("B-20", "D5", "X50@1000S1$", "P1,30$"):
        write(card, text)
    bench.run(2.0)
    command(bench, card, ":Y10:$", seconds=1.0)
    assert number_after_delay(bench, card) == 10
    card.power_cycle()
    assert [card.pins[f"output{n}"].level for n in range(1, 6)] == [False] * 5
    initialise(bench, card)
    before = positions(card)
    for text in ("X$", ":$", "Y$"):
        write(card, text)
    bench.run(1.0)
    assert positions(card) == before
    write(card, "Z1000B@1000$")
    until_idle(bench, card)
    assert moves(card.axes["Z"]) == [1000]
    assert since_start(card.axes["Z"]) == pulse_times_of(ramped(1000, 400, 1000, 100, 10_000))
    seen = edges(card.pins["output1"])
    write(card, "P1$")
    until_idle(bench, card)
    assert seen[1][0] - seen[0][0] == 100 * MS
    assert (number(bench, card, "O"), number(bench, card, "N")) == (0, 1000)


def number_after_delay(bench, card) -> int:
    """Return the answer to N with an inter-character delay of 50 ms."""
    return int(ask(bench, card, "N", 0.5))
