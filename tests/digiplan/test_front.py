"""Every lamp on the front of an IF1, lit in the situation that the manual states, and dark otherwise."""

from itertools import pairwise

import pytest

from axistwin import Bench

from ..fronts import lamps, shown
from .talking import ask, command, play, ready

K, F = "Motion status K", "Communication status F"
STOPS, LINES, OUTPUTS, INPUTS = "Stops and limits", "Lines", "Outputs", "Inputs"
OVERRUN = "X100X100; 0.2 s"
"""A character every 1.15 ms to a buffer that is strobed every 2 ms, which loses some of them."""


SITUATIONS = {
    ("Interface", "LED"): "estop low",
    **{(OUTPUTS, f"{n}"): f"S{n}$; 0.2 s" for n in range(1, 6)},
    (LINES, "RTS"): "host DTR off; K; 0.1 s",  # set prior to the start of transmission, which waits for DSR
    (STOPS, "STOP"): "estop low",
    (STOPS, "+"): "limit_plus low",
    (STOPS, "−"): "limit_minus low",
    (STOPS, "X"): "x_fault low",
    (STOPS, "Y"): "y_fault low",
    **{(INPUTS, f"{n}"): f"input{n} high" for n in range(1, 4)},
    (K, "1"): "X1000@100$; 0.2 s",
    (K, "2"): "X1000@100$; 0.2 s",
    (K, "4"): "X@10000G$; 0.3 s",
    (K, "8"): "X@10000G$; 3 s; #; 0.3 s",  # a deceleration of 0.96 s, at 10,000 steps/s²
    (K, "16"): "y_fault low",
    (K, "32"): "estop low",
    (K, "64"): "limit_minus low",
    (K, "128"): "?; 0.2 s",
    (F, "1"): "power off; power on; detect; U64; 1.3 s; host 8O2; K; 0.2 s",
    (F, "2"): OVERRUN,
    (F, "4"): "break 0.1 s; 0.2 s",
    (F, "8"): "?; 0.2 s",
    (F, "16"): "@30000; 0.2 s",
    (F, "32"): "[; 0.2 s",
}
"""What lights a lamp that is dark on an interface that is ready and has nothing to do: scripts."""
LIT_WHEN_READY = {
    (LINES, "DTR"): "power off",
    (LINES, "DSR"): "host DTR off",
    (LINES, "CTS"): "host RTS off",
    (OUTPUTS, "24 V"): "supply low",
    **{("Directions", axis): f"{axis}-10$; 0.2 s" for axis in "XYZ"},
}
"""What puts out a lamp that is lit there."""


@pytest.mark.parametrize("lamp", SITUATIONS, ids=" ".join)
def test_a_lamp_is_lit_when_the_manual_says_so(bench, lamp):
    if1 = ready(bench, strobe_ms=2 if SITUATIONS[lamp] is OVERRUN else 1)
    assert shown(if1, *lamp) is False
    play(bench, if1, SITUATIONS[lamp])
    assert shown(if1, *lamp) is True


@pytest.mark.parametrize("lamp", LIT_WHEN_READY, ids=" ".join)
def test_a_lamp_that_is_lit_when_it_is_ready_goes_out(bench, if1, lamp):
    assert shown(if1, *lamp) is True
    play(bench, if1, LIT_WHEN_READY[lamp])
    assert shown(if1, *lamp) is False


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_there_is_no_lamp_without_a_situation(model):
    assert lamps(Bench().add(model)) == SITUATIONS.keys() | LIT_WHEN_READY.keys()


def test_the_led_from_power_up_to_ready(bench):
    """Configuring the interface: on for about 1 s, flashing "twice per second" from `(` to the data format."""
    if1 = bench.add("if1")
    lamp = "Interface", "LED"
    assert shown(if1, *lamp) is True
    bench.run(1.2)
    assert shown(if1, *lamp) is False
    if1.serial.write(b"(")
    bench.run(0.1)
    seen = []
    for _ in range(16):
        bench.run(0.125)
        seen.append(shown(if1, *lamp))
    edges = sum(a is not b for a, b in pairwise(seen))
    assert edges in (7, 8), "two flashes per second for two seconds"


def test_the_led_goes_out_when_the_status_has_been_read_and_the_cause_is_gone(bench, if1):
    """Clearing fault conditions: the LED goes out when the status has been read and the fault is gone."""
    lamp = "Interface", "LED"
    if1.pins["estop"].drive(False)
    ask(bench, if1, "K")
    assert shown(if1, *lamp) is True
    if1.pins["estop"].drive(True)
    assert shown(if1, *lamp) is True and ask(bench, if1, "K") == b"32\r"
    assert shown(if1, *lamp) is False


def test_output_5_follows_the_led_with_link_3_in_position_b(bench):
    if1 = ready(bench, fault_output=True)
    if1.pins["estop"].drive(False)
    assert shown(if1, OUTPUTS, "5") is True


@pytest.mark.parametrize(("wiring", "dsr"), [("3-wire", False), ("3-wire DSR-DTR", True)])
def test_dsr_is_what_the_interface_finds(bench, wiring, dsr):
    """DSR linked to RTS reads off until a transmission; DSR linked to DTR reads on."""
    if1 = bench.add("if1", wiring=wiring)
    bench.run(1.5)
    assert [shown(if1, LINES, line) for line in ("DSR", "CTS")] == [dsr, False]


def test_the_state_in_words(bench):
    if1, states = bench.add("if1"), []
    for script in ("0 s", "1.5 s", "power off; power on; detect", "power off"):
        play(bench, if1, script)
        states.append(shown(if1, "Interface", "state"))
    assert states == ["self-test", "waiting for (", "waiting for the data format", "no power"]


@pytest.mark.parametrize(("script", "word"), [
    ("0.2 s", "clear for new commands"), ("X1000@100$; 0.2 s", "busy"), ("estop low", "fault"), ("[; 0.2 s", "locked")
])  # fmt: skip
def test_the_busy_status_in_words(bench, if1, script, word):
    play(bench, if1, script)
    assert shown(if1, "Interface", "E") == word


def test_there_is_no_busy_status_until_the_data_format_has_come(bench):
    """Initialisation: until then it is not "ready to receive move instructions", and E is not answered."""
    if1, words = bench.add("if1"), []
    for script in ("0 s", "1.5 s", "( -> U<CR>", "U61; 0.1 s"):
        play(bench, if1, script)
        words.append(shown(if1, "Interface", "E"))
    assert words == ["no answer yet"] * 3 + ["clear for new commands"]


def test_a_limit_that_was_read_is_no_fault_any_more_while_the_lamp_stays_lit(bench, if1):
    """Clearing fault conditions: a request resets the bit; Installation: the LED is on until the input closes."""
    if1.pins["limit_plus"].drive(False)
    assert ask(bench, if1, "K") == b"64\r"
    assert [shown(if1, K, "64"), shown(if1, "Interface", "LED"), shown(if1, STOPS, "+")] == [False, True, True]
    if1.pins["limit_plus"].drive(True)
    assert [shown(if1, "Interface", "LED"), shown(if1, STOPS, "+")] == [False, False]


def test_the_step_of_a_sequence_and_the_steps_of_a_move(bench, if1):
    """X and Y move 100 steps each at 100 steps/s: after 1.5 s, half of step 2 is done."""
    command(bench, if1, ":X100@100:Y100:$", seconds=1.5)
    assert shown(if1, "Interface", "O") == "2" and 40 <= int(shown(if1, "Interface", "N")) <= 60
    assert ask(bench, if1, "N", 2.0) != b"" and shown(if1, "Interface", "N") == "100"


@pytest.mark.parametrize("seconds", [0.1, 0.5, 1.0, 2.5])
def test_q_and_n_are_what_the_commands_report(bench, if1, seconds):
    """The registers for Q and N equal the answers at the same instant, also in the middle of a ramp."""
    command(bench, if1, "X12000@9000$", seconds=seconds)
    for register, request in (("Q", b"K\r"), ("N", b"N\r")):
        if1.serial.read()
        if1.serial.write(request)
        assert bench.run_until(lambda: if1.terminals["rts"].level, 1)
        expected = if1.registers[register].read()
        bench.run(0.1)
        assert int(if1.serial.read()) == expected
