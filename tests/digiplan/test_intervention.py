"""Sequence mode: controller intervention in a sequence, `%`."""

import pytest

from ..scripts import scripts
from .talking import arrivals, ask, command, gaps, play, positions, ready, send, times, until_idle, write


@scripts({
    # Y- moves by the latest distance
    'Intervention: it "transmits "% <CR>"" after Y 400 and "resumes with the negative Y move when "% <CR>""':
    ": Y 400 @ 200 : % : Y- : $; 1.9 s; Y between 1 399; 0.2 s; receives %<CR>; at 0 400 0; X150@400$; 60 s; "
    "at 150 400 0; Z400@400$; idle; %; idle; at 150 0 400; Y moves 400 -400",
    "Intervention: the host changes the speed and the distance, then gives control back":
    ":%:X:$; 0.1 s; receives %<CR>; @100; 0.1 s; Z25$; 1 s; %; idle; at 25 0 25; X 25 pulses at 100",
    'R20: "In a `%` hand-over with nothing moving: C"; moving, E; O names the `%` step':
    ":S1:%:X10@400:$; 0.1 s; receives %<CR>; E: C; K: 0; O: 2; Y400$; E: E; K: 3; 2 s; E: C; %; idle; at 10 400 0",
    "Intervention: after a move and `%` at once, the sequence continues when the move has ended":
    ":%:X10:$; 0.1 s; receives %<CR>; Y400@400$; %; 0.5 s; X at 0; 1 s; at 10 400 0; X begins 0 to 5 ms after Y",
    'Intervention, in each pass: "where data-dependent moves must be included in a preset sequence"':
    ":X10@400:%:=2,1:$; 0.5 s; receives %<CR>; Y1$; 0.5 s; %; 0.5 s; receives %<CR>; Y2$; 0.5 s; %; 0.5 s; "
    "receives %<CR>; Y3$; 0.5 s; %; 0.5 s; at 30 6 0; E: C",
    "Intervention: each `%` of the sequence needs a `%` of its own":
    ":%:%:X10@400:$; 0.2 s; receives %<CR>; %; 0.2 s; receives %<CR>; at 0 0 0; %; 0.2 s; at 10 0 0",
    'Repeating: "the cancel code ... terminates the sequence"; after that `%` resumes nothing':
    ":X10@400:%:X20:$; 0.5 s; receives %<CR>; #; 0.1 s; %; 0.5 s; at 10 0 0; F?; :$; 0.5 s; "
    "receives %<CR>; at 20 0 0",
    'Command list: `%` is "Wait for control"; without a hand-over there is nothing to resume':
    "%; 0.1 s; at 0 0 0; :X100@400:P0,50:Y10:$; 0.1 s; %; 0.2 s; %; 2 s; at 100 10 0; F: 8; E: C",
    'Control lines: "will therefore not transmit data until DSR and CTS are both set"; R4':
    "host RTS off; :X10@400:%:Y10:$; 1 s; at 10 0 0; host RTS on; 0.1 s; receives %<CR>; at 10 0 0; %; "
    "idle; at 10 10 0",
    'Report-back: "The interface can be interrogated to establish its status at any time"':
    ":%:X10@400:$; 0.1 s; receives %<CR>; K: 0; F: 0; I: 200; O: 1; E: C; N: 0; Q: 0; %; 0.2 s; at 10 0 0",
    "R22: a sequence ends with a fault, handed over or not":
    ":%:X10@400:$; 0.1 s; receives %<CR>; Y4000$; 0.5 s; estop low; 0.5 s; estop released; K: 32; %; 0.5 s; X at 0",
    'Clearing: "any axis in motion will stop"; a limit that a host\'s move meets ends the sequence, too':
    ":%:X10@400:$; 0.1 s; receives %<CR>; Y@400G$; 0.5 s; limit_plus low; 0.1 s; E: F; K: 64; mark; %; 0.5 s; "
    "moved 0 0 0; F: 8; E: C",
    'Clearing: "further movement is inhibited": a host\'s move towards a limit is refused and ends the sequence':
    "limit_plus low; K: 64; :%:X-10@400:$; 0.1 s; receives %<CR>; Y5$; 0.1 s; K: 64; %; 0.5 s; at 0 0 0; F: 8",
    'Cancel: "This will stop any axis in motion"; it also ends the sequence that has handed over control':
    ":%:X20@400:$; 0.1 s; receives %<CR>; Y4000$; 1 s; #; 0.1 s; E: C; Y between 1 3999; mark; %; 1 s; moved 0 0 0",
    'Intervention: "execute any move instruction it receives": a sequence within a sequence is a data fault':
    ":%:X10@400:$; 0.1 s; receives %<CR>; :Y5@400:Z5:$; :$; 1 s; at 0 0 0; F: 8; %; 1 s; at 10 0 0",
    # I is asked while DSR holds the line; its answer and the prompt wait together
    'Control lines: "will therefore not transmit data until DSR and CTS are both set": each message comes whole':
    "host DTR off; :P0,5:%:Y1:$; I; 0.5 s; host DTR on; 0.1 s; receives 200<CR>%<CR>; #",
    # with D5 the prompt begins 50 ms after the step, its CR 50 ms later
    "Inter-character delay: a prompt that `#` meets between `%` and CR is completed":
    "D5; :%:Y1:$; 0.09 s; receives %; #; 0.1 s; receives <CR>; E; 0.2 s; receives C<CR>",
    "Inter-character delay: a prompt that an emergency stop meets between `%` and CR is completed":
    "D5; :%:Y1:$; 0.09 s; receives %; estop low; 0.1 s; receives <CR>; estop released; E; 0.2 s; receives F<CR>",
    'Busy status: a run that the host begins in a hand-over is "busy"; `%` and `#` are obeyed meanwhile':
    ":%:Y10:A:$; 0.1 s; receives %<CR>; X@500G$; 0.5 s; K: 3; E: E; %; 0.1 s; X runs at 500; #; 1 s; E: C; Y at 0",
    "Acceleration rate: ramp data wait for the end of a run that goes on into the next hand-over":
    ":%:%:A:Y5@400:$; 0.1 s; receives %<CR>; X@500G$; 0.1 s; ^20; %; 0.1 s; receives %<CR>; K: 3; E: E; %; 3 s; "
    "Y at 5; E: C",
    "Acceleration rate: data sent during a run in a hand-over; the ramp is calculated after the run":
    ":%:Y10:$; 0.1 s; receives %<CR>; X@500G$; 0.5 s; ^20; K: 3; #; 1.2 s; K: 0; E: C",
    "R7: `%` anywhere else is a data fault, and the message moves nothing":
    "{X10%$|%X10$|%$|%%|S1%}; 0.5 s; at 0 0 0; outputs 00000; F: 8",
})  # fmt: skip
def test_control_given_to_the_host(bench, if1, script):
    play(bench, if1, script)


def test_the_prompt_comes_when_the_move_before_has_ended(bench, if1):
    """Intervention: "Following the Y move of 400 steps"."""
    heard = arrivals(bench, if1)
    write(if1, ":Y400@200:%:$")
    bench.run(3.0)
    # a character of 11 bits at 9600 baud takes 1.15 ms; the prompt follows the move within a few of them
    assert 0 < heard[0][0] - times(if1.axes["Y"])[-1] < 5_000_000


def test_the_prompt_ends_as_the_data_format_says(bench):
    """Intervention, Initialisation: in the V format <CR> "should be interpreted as representing <CR><LF>"."""
    if1 = ready(bench, "V61")
    assert send(bench, if1, ":%:X10@400:$", end="\n") == b"%\r\n"
    command(bench, if1, "%", end="\r\n")
    assert positions(if1) == (10, 0, 0)


def test_the_instruction_may_have_inputs_outputs_and_ramp_data(bench, if1):
    """ "combined with input and output commands, as well as acceleration rate and start/stop speed data"."""
    play(bench, if1, "input1 low; :X100@400:%:Y600@1000:$; 0.5 s; receives %<CR>; ^20 <6; 1.2 s; H1Z50@600S3$; 1 s; "
         "Z at 0; E: E; input1 high; 0.2 s; Z at 50; output3 is high; %")  # fmt: skip
    until_idle(bench, if1)
    # start/stop 600, acceleration 20,000: levels 600, 700, 800, 900 of 5 ms: 3 + 3.5 + 4 + 4.5 = 15 pulses each way,
    # 570 at 1000 steps/s: from the start to the last pulse 20 + 570 + 20 ms, the first pulse after 1/600 s
    y = times(if1.axes["Y"])
    assert len(y) == 600 and y[-1] - y[0] == 610_000_000 - 1_666_666
    assert set(gaps(y[20:580])) == {1_000_000}


def test_with_echo_the_prompt_is_not_mixed_up_with_the_echo(bench):
    """Echo back: "each character is returned to the controller"; the prompt `%` is sent in addition to the echo."""
    script = (
        ":X10@400:%:Y10:$; 0.2 s; receives :X10@400:%:Y10:$<CR>%<CR>; Z5$; 0.2 s; receives Z5$<CR>; %; 0.2 s; "
        "receives %<CR>; 0.5 s; at 10 10 5"
    )
    play(bench, ready(bench, "U62"), script)


@pytest.mark.parametrize("line", ["dtr", "rts"])
def test_a_prompt_that_is_cancelled_before_it_may_be_sent_leaves_rts_reset(bench, if1, line):
    """Control lines: RTS is "set prior to the start of transmission": a cancelled prompt resets RTS."""
    setattr(if1.serial.host, line, False)
    command(bench, if1, ":%:Y5:$", seconds=0.1)
    assert if1.serial.rts
    command(bench, if1, "#", seconds=0.1)
    assert not if1.serial.rts
    setattr(if1.serial.host, line, True)
    assert ask(bench, if1, "E") == b"C\r" and not if1.serial.rts


def test_a_reply_that_waits_with_a_cancelled_prompt_keeps_rts_set(bench, if1):
    """Control lines: RTS stays set for another reply, which is sent as soon as DSR and CTS are set."""
    play(bench, if1, "host DTR off; :%:Y5:$; K; #; 0.1 s")
    assert if1.serial.rts
    play(bench, if1, "host DTR on; 0.1 s; receives 0<CR>")
    assert not if1.serial.rts
