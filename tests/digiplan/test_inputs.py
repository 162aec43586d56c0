"""Output control: Combining inputs and outputs with move instructions."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .talking import edges, moves, play, start_ns, times


def test_the_move_begins_when_input_1_goes_high_and_sets_output_3_at_its_end(bench, if1):
    """Combining: "H1 X 1000 @ 200 S3 $": "begin when input 1 goes high. At the end of the move, output 3 is set"."""
    play(bench, if1, "H1 X 1000 @ 200 S3 $; 2 s; still")
    output, began = edges(if1.pins["output3"]), bench.now
    play(bench, if1, "input1 high; 6 s; X 1000 pulses at 200")
    assert began <= start_ns(if1.axes["X"]) <= began + 2 * MS
    last = times(if1.axes["X"])[-1]
    assert len(output) == 1 and output[0][1] and last <= output[0][0] <= last + 2 * MS


@scripts({
    'Combining: H and L "specify a high or low state": levels, not edges':
    "input1 high; H1X10$; 0.1 s; X at 10; L2X10$; 0.1 s; X at 20",
    'Busy status: "waiting for inputs"; "In this respect it is different from the "in motion" status"':
    "H1X1000$; E: E; K: 0; N: 0",
    "Cancel: the move that waits for an input is not made": "H1X1000$; 0.1 s; #; E: C; input1 high; 1 s; X at 0",
    "Combining: a short high level during the wait is enough":
    "H3X20$; 0.1 s; input3 high; 0.005 s; input3 low; 0.5 s; X at 20",
    "Combining: move instructions, run mode among them": "H2XG$; 0.5 s; still; input2 high; 0.5 s; X runs at 400",
    "Combining: the stages one after the other, the move being empty":
    "H1X0S1$; 0.2 s; output1 is low; input1 high; 0.05 s; output1 is high; X at 0",
    "Index mode: the rest of the message is lost with the index": "X400S1$; 0.3 s; #; 2 s; output1 is low",
    "Input status: a bit is 1 when there is no current: 8 + 64 + 128 with the three inputs open":
    "I: 200; input1 high; I: 192; input2 high; input3 high; I: 0; input1 released; input2 released; "
    "input3 released; I: 200",
    'Combining: "H12 X 1000 @ 200 $": "This move will commence when inputs 1 and 2 are high"':
    "H12 X 1000 @ 200 $; 0.1 s; input1 high; 0.1 s; input1 low; input2 high; 0.1 s; still; input1 high; 0.01 s; "
    "moving",
    # a low on input 3 before input 1 was high has no effect, and input 1 need not stay high
    'Combining: "H1 L3 X 1000 @ 200 $": "starts when input 1 goes high followed by a low on input 3"':
    "input3 high; H1 L3 X 1000 @ 200 $; 0.1 s; input3 low; 0.1 s; input3 high; 0.1 s; input1 high; 0.1 s; still; "
    "input1 low; 0.1 s; input3 low; 0.01 s; moving",
    'Combining: " H2 L2 X 1000 @ 200 $": "performed following a high-to-low transition on input 2"':
    " H2 L2 X 1000 @ 200 $; 0.5 s; still; input2 high; 0.5 s; still; input2 low; 0.01 s; moving",
    'Combining: "L13 X 1000 @ 200 S23 R5 $": "outputs 2 and 3 will be turned on and output 5 will be turned off"':
    "S5$; input1 high; input3 high; L13 X 1000 @ 200 S23 R5 $; 0.1 s; input1 low; 0.1 s; still; input3 low; "
    "4.9 s; outputs 00001; 0.2 s; outputs 01100; X at 1000",
    'Combining: "H1 L23 X 1000 @ 200 P4, 20 $": "following the move, output 4 is pulsed for 200ms"':
    "input2 high; input3 high; H1 L23 X 1000 @ 200 P4, 20 $; 0.1 s; input1 high; 0.1 s; input2 low; 0.1 s; still; "
    "input3 low; 4.9 s; outputs unchanged; until X at 1000; 0.002 s; output4 is high; 1 s; output4 high for 200 ms",
    'Combining: "Input commands can only be used in combination with move commands"':
    "input1 high; input2 high; {H1|L2|H1L2|H1S2|H1P0,5|H1R1|H12L3S1R2}$; 0.2 s; outputs unchanged; K: 128; F: 8",
    'Combining: "Not all the stages ... need be included, but the remainder MUST be sent in the order shown"':
    "input1 high; {L1H2X10$|X10H1$|X10L1$|X10S1H1$|S1X10$|R1X10$|X10R1S2$|P1X10$|X10S1P2,5$|X10P2,5R1$|H1H2X10$|"
    "X10$S1|$X10|X10$$|H1X10S1L2$}; 0.3 s; X at 0; outputs unchanged; K: 128; F: 8; E: C",
    'Combining: "Not all the stages shown above need be included"':
    "input1 high; {X10S1|X10R1|X10S1R2|X10P1,1|H1X10|L2X10R12|H1L2X10S3R4|X10@300BS1}$; 0.5 s; X at 10; K: 0; F: 0",
})  # fmt: skip
def test_waiting_for_inputs(bench, if1, script):
    play(bench, if1, script)


@scripts({
    # message and inputs, then the step and its next input
    "Combining: until inputs 1 and 2 are high": "input1 high; H12X$; 0.1 s / the move waits for input2 high",
    "Combining: H before L": "input1 high; :P0,1:H2L1X:$; 0.1 s / step 2 of the sequence waits for input2 high",
    "Combining: L after H": "input1 high; input2 high; H2L1X$; 0.1 s / the move waits for input1 low",
    "Combining: no wait": "input1 high; H1X$; 0.1 s / ",
    "Power requirements: no wait without power": "H1X$; 0.1 s; power off / ",
})  # fmt: skip
def test_it_tells_for_which_input_it_waits(bench, if1, script):
    """The hint for the user names the step, and the first input that keeps it waiting."""
    acts, waits = script.split(" / ")
    play(bench, if1, acts)
    assert if1.hint.partition(":")[0] == waits


@pytest.mark.parametrize("message", ["H4X10$", "L0X10$", "H14X10$", "HX10$", "LX10$", "H,1X10$", "H9X10$"])
def test_there_are_three_inputs(bench, if1, message):
    """Optically-isolated inputs: "There are three inputs"."""
    play(bench, if1, f"input1 high; input2 high; input3 high; {message}; 0.3 s; X at 0; K: 128; F: 8|16")


def test_outputs_change_when_the_slowest_part_of_the_move_is_over(bench, if1):
    """Combining: "one or more outputs will change state at the end of the move", after its backlash correction."""
    output = edges(if1.pins["output1"])
    play(bench, if1, "B-40; X40BS1$; 1 s")
    assert moves(if1.axes["X"]) == [80, -40] and output[0][0] >= times(if1.axes["X"])[-1]
