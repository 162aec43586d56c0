"""Output control: Output switching commands."""

import itertools

import pytest

from axistwin.units import MS

from .talking import command, edges, faults, play, ready, scripts, start_ns, write


def levels(if1) -> str:
    """Return the levels of outputs 1 to 5 as five digits."""
    return "".join(str(int(if1.pins[f"output{n}"].level)) for n in range(1, 6))


def pulses(seen: list[tuple[int, bool]]) -> list[tuple[int, bool]]:
    """Return the length in ns and the level between each two changes."""
    return [(after - before, level) for (before, level), (after, _) in itertools.pairwise(seen)]


@scripts(
    {
        'Default values: "Outputs 1-5 - Off (reset)"': "outputs 00000",
        'Outputs: ""S2 $ <CR>" turns on output 2"': "S2 $; 0.05 s; outputs 01000",
        'Outputs: ""S13 R2 $ <CR>" turns outputs 1 and 3 on, and turns output 2 off"':
        "S2$; S13 R2 $; 0.05 s; outputs 10100",
        'Outputs: "followed by the output number and the "$" character"': "S2; 0.05 s; outputs 00000",
        'Busy status: "motionless" activities such as waiting for inputs and pulsing outputs"':
        "P1,90$; E: E; K: 0; 1 s; E: C",
        "Cancel: it ends a pulse in progress": "P1,99$; 0.1 s; #; E: C; S2$; 0.05 s; output2 is high",
        "Outputs: only S, R and P change them": "S135$; X400$; 0.3 s; #; 0.3 s; outputs 10101",
        "Default values: outputs are off when power is applied":
        "S12345$; 0.1 s; power off; outputs 00000; power on; 2 s; outputs 00000",
    }
)  # fmt: skip
def test_output_levels(bench, if1, script):
    play(bench, if1, script)


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
    assert second[0][0] >= first[1][0]  # the second pulse begins after the first one


@pytest.mark.parametrize("length", [1, 2, 50, 98, 99])
def test_increments_of_10_ms_up_to_990(bench, if1, length):
    """Outputs: "pulse length in increments of 10mS. The maximum pulse length is 990mS"."""
    seen = edges(if1.pins["output3"])
    command(bench, if1, f"P3,{length}$", seconds=2)
    assert pulses(seen) == [(length * 10 * MS, True)]


@pytest.mark.parametrize("message", ["P4,100$", "P4,999$", "P4,0$", "P0,100$", "P4,100"])
def test_a_longer_pulse_is_out_of_range(bench, if1, message):
    """R25: out of range; the previous length is kept."""
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


def test_switching_while_a_motor_runs_waits_for_it(bench, if1):
    """R9: switching is held until the motion has ended, like all `$` messages."""
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
