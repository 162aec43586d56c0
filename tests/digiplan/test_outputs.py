"""Output control: Output switching commands."""

import pytest

from ..scripts import scripts
from .talking import play, ready


@scripts({
    'Outputs: ""S2 $ <CR>" turns on output 2"': "S2 $; 0.05 s; outputs 01000",
    'Outputs: ""S13 R2 $ <CR>" turns outputs 1 and 3 on, and turns output 2 off"':
    "S2$; S13 R2 $; 0.05 s; outputs 10100",
    'Outputs: "followed by the output number and the "$" character"': "S2; 0.05 s; outputs 00000",
    'Busy status: "motionless" activities such as waiting for inputs and pulsing outputs"':
    "P1,90$; E: E; K: 0; 1 s; E: C",
    'Outputs: "the prior state of the output" returns when the cancel code ends a pulse':
    "S4$; P4,99$; 0.1 s; outputs 00000; #; 0.005 s; outputs 00010; 2 s; outputs 00010; E: C",
    'Combining: "At the end of the move, output 3 is set": a move that is cancelled has not come to it':
    "S4$; X100@200S3R4$; 0.1 s; #; 1 s; outputs 00010; X100@200P3,20$; 0.1 s; #; 1 s; outputs 00010; E: C",
    "Cancel: it ends a pulse in progress": "P1,99$; 0.1 s; #; E: C; S2$; 0.05 s; output2 is high",
    "Outputs: only S, R and P change them": "S135$; X400$; 0.3 s; #; 0.3 s; outputs 10101",
    "Default values: outputs are off when power is applied":
    "S12345$; 0.1 s; power off; outputs 00000; power on; 2 s; outputs 00000",
    'Outputs: "The 5 optically-isolated outputs may be set high or reset low under program control"':
    "S12345$; 0.1 s; outputs 11111; R24$; 0.1 s; outputs 10101; R12345$; 0.1 s; outputs 00000; S54321$; 0.1 s; "
    "outputs 11111; R54321$; S1$; S2$; S5$; 0.1 s; outputs 11001; K: 0; F: 0",
    "Outputs: of S and R in one message, S is executed first": "S1R1$; 0.1 s; outputs 00000; K: 0; F: 0",
    "Outputs: an output that is off may be reset": "R1$; S 1 2 $; R 2 $; 0.1 s; outputs 10000; K: 0; F: 0",
    'Outputs: ""P4, 20 $ <CR>" will generate a pulse 200mS long on output 4"':
    "P4, 20 $; 1 s; output4 high for 200 ms; outputs 00000",
    'Outputs: "The phase of the output pulse will depend on the prior state of the output"':
    "S4$; 0.05 s; P4,20$; 1 s; output4 low for 200 ms; outputs 00010",
    # the second pulse begins after the first one
    'Acceleration: "will remember any programmed data unless it is overwritten": the pulse length, too':
    "P4,20$; P5$; until output4 is high; 0.199 s; outputs 00010; 0.8 s; output4 high for 200 ms; "
    "output5 high for 200 ms",
    'Outputs: "pulse length in increments of 10mS. The maximum pulse length is 990mS"':
    "P3,1$; P3,2$; P3,50$; P3,98$; P3,99$; 3 s; output3 high for 10 20 500 980 990 ms",
    'Adding time delays: "pulse output command "P" and specifying output 0": 500 ms, busy but not in motion':
    "P0,50$; S1$; 0.5 s; outputs 00000; 0.03 s; outputs 10000; P0,50$; E: E; K: 0",
    "R9: switching is held until the motion has ended, like all `$` messages":
    "X40$; S1$; until X moving; 0.099 s; outputs 00000; until X at 40; 0.005 s; outputs 10000",
    'Outputs: "always send the set command first"; "an output cannot be pulsed at the same time as other outputs"':
    "S2$; {R2S1|S|R|P|S1S2|S1P2|R1P2,5|P2,5S1|S1,2|P1,}$; 0.05 s; outputs 01000; K: 128; F: 8",
    "R25: out of range; the previous length is kept":
    "P{4,100$|4,999$|4,0$|0,100$|4,100}; 0.05 s; K: 128; F: 16; P4$; 1 s; output4 high for 100 ms",
})  # fmt: skip
def test_output_levels(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("message", ["S6$", "S0$", "S16$", "R9$", "P6,5$", "P9$", "S123456$"])
def test_there_are_five_outputs(bench, if1, message):
    """Outputs: "The 5 optically-isolated outputs"."""
    play(bench, if1, f"{message}; 0.05 s; outputs unchanged; K: 128; F: 8|16")


def test_with_link_3_in_position_b_output_5_is_not_programmable(bench):
    """Optional fault output: "The output cannot be controlled by program commands with the link in this position"."""
    if1 = ready(bench, fault_output=True)
    play(bench, if1, "S5$; S1$; P5,5$; 0.5 s; outputs 10000; output5 high for ms; output5 low for ms")
