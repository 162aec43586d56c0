"""Output control: Output switching commands."""

import itertools

import pytest

from axistwin.units import MS

from .talking import ask, command, edges, faults, ready, start_ns, write


def levels(if1) -> str:
    """Outputs 1 to 5 as five digits."""
    return "".join(str(int(if1.pins[f"output{n}"].level)) for n in range(1, 6))


def pulses(seen: list[tuple[int, bool]]) -> list[tuple[int, bool]]:
    """(length in ns, level) of each stretch between two changes."""
    return [(after - before, level) for (before, level), (after, _) in itertools.pairwise(seen)]


def test_all_outputs_are_off_at_power_on(bench, if1):
    """Default values: "Outputs 1-5 - Off (reset)"."""
    assert levels(if1) == "00000"


def test_s2_turns_on_output_2(bench, if1):
    """Outputs: ""S2 $ <CR>" turns on output 2"."""
    command(bench, if1, "S2 $", seconds=0.05)
    assert levels(if1) == "01000"


def test_s13_r2_turns_1_and_3_on_and_2_off(bench, if1):
    """Outputs: ""S13 R2 $ <CR>" turns outputs 1 and 3 on, and turns output 2 off"."""
    command(bench, if1, "S2$", "S13 R2 $", seconds=0.05)
    assert levels(if1) == "10100"


@pytest.mark.parametrize(
    ("messages", "expected"),
    [
        (["S12345$"], "11111"),
        (["S54321$"], "11111"),
        (["S12345$", "R12345$"], "00000"),
        (["S1$", "S2$", "S5$"], "11001"),
        (["S12345$", "R24$"], "10101"),
        (["R1$"], "00000"),
        (["S 1 2 $", "R 2 $"], "10000"),
        (["S1R1$"], "00000"),  # set first, then reset
    ],
)
def test_set_and_reset(bench, if1, messages, expected):
    """Outputs: "The 5 optically-isolated outputs may be set high or reset low under program control"."""
    for message in messages:
        write(if1, message)
    bench.run(0.1)
    assert levels(if1) == expected
    assert faults(bench, if1) == (b"0\r", b"0\r")


@pytest.mark.parametrize(
    "message", ["R2S1$", "S$", "R$", "P$", "S1S2$", "S1P2$", "R1P2,5$", "P2,5S1$", "S1,2$", "P1,$"]
)
def test_the_wrong_order_is_a_data_fault_and_changes_nothing(bench, if1, message):
    """Outputs: "always send the set command first"; "an output cannot be pulsed at the same time as other outputs"."""
    command(bench, if1, "S2$", message, seconds=0.05)
    assert (levels(if1), faults(bench, if1)) == ("01000", (b"128\r", b"8\r"))


@pytest.mark.parametrize("message", ["S6$", "S0$", "S16$", "R9$", "P6,5$", "P9$", "S123456$"])
def test_there_are_five_outputs(bench, if1, message):
    """Outputs: "The 5 optically-isolated outputs"."""
    command(bench, if1, message, seconds=0.05)
    assert levels(if1) == "00000"
    answer = faults(bench, if1)
    assert answer[0] == b"128\r" and answer[1] in (b"8\r", b"16\r")


def test_without_the_dollar_sign_nothing_is_switched(bench, if1):
    """Outputs: "followed by the output number and the "$" character"."""
    command(bench, if1, "S2", seconds=0.05)
    assert levels(if1) == "00000"


def test_a_pulse_200_ms_long_on_output_4(bench, if1):
    """Outputs: ""P4, 20 $ <CR>" will generate a pulse 200mS long on output 4"."""
    seen = edges(if1.pins["output4"])
    command(bench, if1, "P4, 20 $", seconds=1)
    assert pulses(seen) == [(200 * MS, True)]
    assert levels(if1) == "00000"


def test_the_phase_of_the_pulse_depends_on_the_prior_state(bench, if1):
    """Outputs: "The phase of the output pulse will depend on the prior state of the output"."""
    command(bench, if1, "S4$", seconds=0.05)
    seen = edges(if1.pins["output4"])
    command(bench, if1, "P4,20$", seconds=1)
    assert pulses(seen) == [(200 * MS, False)]
    assert levels(if1) == "00010"


def test_the_default_pulse_is_100_ms(bench, if1):
    """Default values: "Pulse output - 10 (100mS)"."""
    seen = edges(if1.pins["output1"])
    command(bench, if1, "P1$", seconds=1)
    assert pulses(seen) == [(100 * MS, True)]


def test_the_pulse_length_is_remembered(bench, if1):
    """Acceleration: "will remember any programmed data unless it is overwritten"."""
    first, second = edges(if1.pins["output4"]), edges(if1.pins["output5"])
    command(bench, if1, "P4,20$", "P5$", seconds=1)
    assert pulses(first) == pulses(second) == [(200 * MS, True)]
    assert second[0][0] >= first[1][0]  # one after the other


@pytest.mark.parametrize("length", [1, 2, 50, 98, 99])
def test_increments_of_10_ms_up_to_990(bench, if1, length):
    """Outputs: "pulse length in increments of 10mS. The maximum pulse length is 990mS"."""
    seen = edges(if1.pins["output3"])
    command(bench, if1, f"P3,{length}$", seconds=2)
    assert pulses(seen) == [(length * 10 * MS, True)]


@pytest.mark.parametrize("message", ["P4,100$", "P4,999$", "P4,0$", "P0,100$", "P4,100"])
def test_a_longer_pulse_is_out_of_range(bench, if1, message):
    """R25: out of range; and the length stays as it was."""
    seen = edges(if1.pins["output4"])
    command(bench, if1, message, seconds=0.05)
    assert faults(bench, if1) == (b"128\r", b"16\r")
    command(bench, if1, "P4$", seconds=1)
    assert pulses(seen) == [(100 * MS, True)]


def test_output_0_is_a_delay(bench, if1):
    """Adding time delays: "pulse output command "P" and specifying output 0": 500 ms, busy but not in motion."""
    write(if1, "P0,50$", "S1$")
    seen = edges(if1.pins["output1"])
    begin = bench.now
    bench.run(0.45)
    assert levels(if1) == "00000"
    bench.run(0.5)
    assert begin + 500 * MS <= seen[0][0] <= begin + 530 * MS


def test_pulsing_is_busy_and_not_in_motion(bench, if1):
    """Busy status: "motionless" activities such as waiting for inputs and pulsing outputs"."""
    write(if1, "P1,90$")
    assert (ask(bench, if1, "E"), ask(bench, if1, "K")) == (b"E\r", b"0\r")
    bench.run(0.7)
    assert ask(bench, if1, "E") == b"C\r"


def test_cancel_ends_a_pulse(bench, if1):
    """Cancel: it ends what is going on."""
    command(bench, if1, "P1,99$", seconds=0.1)
    write(if1, "#")
    assert ask(bench, if1, "E", 0.05) == b"C\r"
    command(bench, if1, "S2$", seconds=0.05)
    assert if1.pins["output2"].level


def test_outputs_stay_as_they_are_through_moves_and_cancel(bench, if1):
    """Outputs: they change on set, reset and pulse only."""
    command(bench, if1, "S135$", "X400$", seconds=0.3)
    command(bench, if1, "#", seconds=0.3)
    assert levels(if1) == "10101"


def test_power_off_turns_them_off(bench, if1):
    """Default values: off when the power is applied."""
    command(bench, if1, "S12345$", seconds=0.1)
    if1.power(False)
    assert levels(if1) == "00000"
    if1.power(True)
    bench.run(2)
    assert levels(if1) == "00000"


def test_switching_while_a_motor_runs_waits_for_it(bench, if1):
    """R9: `$` messages are held until the current work is done."""
    write(if1, "X40$", "S1$")
    seen = edges(if1.pins["output1"])
    bench.run(1)
    ends = start_ns(if1.axes["X"]) + 100 * MS
    assert ends <= seen[0][0] <= ends + 5 * MS


def test_with_link_3_in_position_b_output_5_is_not_programmable(bench):
    """Optional fault output: "The output cannot be controlled by program commands with the link in this position"."""
    if1 = ready(bench, fault_output=True)
    write(if1, "S5$", "S1$", "P5,5$")
    seen = edges(if1.pins["output5"])
    bench.run(0.5)
    assert levels(if1) == "10000" and seen == []
