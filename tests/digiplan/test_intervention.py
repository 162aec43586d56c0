"""Sequence mode: controller intervention in a sequence, `%`."""

import pytest

from .talking import (
    ask,
    command,
    gaps,
    moves,
    number,
    play,
    positions,
    ready,
    scripts,
    send,
    status,
    status_word,
    times,
    until_idle,
    write,
)


def test_the_sequence_hands_over_and_resumes(bench, if1):
    """Intervention: after Y 400 it "transmits "% <CR>"" and "resumes with the negative Y move when "% <CR>""."""
    assert send(bench, if1, ": Y 400 @ 200 : % : Y- : $", seconds=1.9) == b""
    bench.run(0.2)
    assert (if1.serial.read(), positions(if1)) == (b"%\r", (0, 400, 0))

    command(bench, if1, "X150@400$", seconds=60.0)
    assert positions(if1) == (150, 400, 0)
    write(if1, "Z400@400$")
    until_idle(bench, if1)
    write(if1, "%")
    until_idle(bench, if1)
    assert positions(if1) == (150, 0, 400)  # Y- moves by the latest distance
    assert moves(if1.axes["Y"]) == [400, -400]


def test_the_prompt_comes_when_the_move_before_has_ended(bench, if1):
    """Intervention: "Following the Y move of 400 steps"."""
    write(if1, ":Y400@200:%:$")
    heard: list[int] = []
    if1.serial.subscribe_received(lambda byte, errors: heard.append(bench.now))
    bench.run(3.0)
    # a character of 11 bits at 9600 baud takes 1.15 ms; the prompt follows the move within a few of them
    assert 0 < heard[0] - times(if1.axes["Y"])[-1] < 5_000_000


def test_the_prompt_ends_as_the_data_format_says(bench):
    """Intervention, Initialisation: in the V format <CR> "should be interpreted as representing <CR><LF>"."""
    if1 = ready(bench, "V61")
    assert send(bench, if1, ":%:X10@400:$", end="\n") == b"%\r\n"
    command(bench, if1, "%", end="\r\n")
    assert positions(if1) == (10, 0, 0)


def test_the_instruction_may_have_inputs_outputs_and_ramp_data(bench, if1):
    """ "combined with input and output commands, as well as acceleration rate and start/stop speed data"."""
    if1.pins["input1"].drive(False)
    assert send(bench, if1, ":X100@400:%:Y600@1000:$", seconds=0.5) == b"%\r"
    command(bench, if1, "^20 <6", seconds=1.2)
    command(bench, if1, "H1Z50@600S3$", seconds=1.0)
    assert positions(if1)[2] == 0 and status(bench, if1, "E") == "E"
    if1.pins["input1"].drive(True)
    bench.run(0.2)
    assert positions(if1)[2] == 50 and if1.pins["output3"].level
    write(if1, "%")
    until_idle(bench, if1)
    # start/stop 600, acceleration 20,000: levels 600, 700, 800, 900 of 5 ms: 3 + 3.5 + 4 + 4.5 = 15 pulses each way,
    # 570 at 1000 steps/s: from the start to the last pulse 20 + 570 + 20 ms, the first pulse after 1/600 s
    y = times(if1.axes["Y"])
    assert len(y) == 600
    assert y[-1] - y[0] == 610_000_000 - 1_666_666
    assert set(gaps(y[20:580])) == {1_000_000}


def test_parameters_alone_are_taken_too(bench, if1):
    """Intervention: the host changes the speed and the distance, then gives control back."""
    write(if1, ":%:X:$")
    bench.run(0.1)
    write(if1, "@100")
    bench.run(0.1)
    write(if1, "Z25$")
    bench.run(1.0)
    write(if1, "%")
    until_idle(bench, if1)
    assert (positions(if1), set(gaps(times(if1.axes["X"])))) == ((25, 0, 25), {10_000_000})


def test_a_handed_over_interface_is_clear(bench, if1):
    """R20: "In a `%` hand-over with nothing moving: C"; moving, E; O names the `%` step."""
    assert send(bench, if1, ":S1:%:X10@400:$", seconds=0.1) == b"%\r"
    assert (status(bench, if1, "E"), status_word(bench, if1), number(bench, if1, "O")) == ("C", 0, 2)
    write(if1, "Y400$")
    assert (status(bench, if1, "E"), status_word(bench, if1)) == ("E", 3)
    bench.run(2.0)
    assert status(bench, if1, "E") == "C"
    write(if1, "%")
    until_idle(bench, if1)
    assert positions(if1) == (10, 400, 0)


def test_resuming_while_the_hosts_move_still_runs_waits_for_it(bench, if1):
    """Intervention: after a move and `%` at once, the sequence continues when the move has ended."""
    write(if1, ":%:X10:$")
    bench.run(0.1)
    write(if1, "Y400@400$", "%")
    bench.run(0.5)
    assert positions(if1)[0] == 0
    bench.run(1.0)
    assert positions(if1) == (10, 400, 0)
    assert times(if1.axes["X"])[0] > times(if1.axes["Y"])[-1]


def test_each_pass_of_a_repeat_hands_over_anew(bench, if1):
    """Intervention, in each pass: "where data-dependent moves must be included in a preset sequence"."""
    write(if1, ":X10@400:%:=2,1:$")
    for moved in (1, 2, 3):
        bench.run(0.5)
        assert if1.serial.read() == b"%\r"
        command(bench, if1, f"Y{moved}$", seconds=0.5)
        write(if1, "%")
    bench.run(0.5)
    assert positions(if1) == (30, 6, 0)
    assert if1.serial.read() == b"" and status(bench, if1, "E") == "C"


@scripts(
    {
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
    }
)  # fmt: skip
def test_control_given_to_the_host(bench, if1, script):
    play(bench, if1, script)


def test_cancelling_the_hosts_own_move_ends_the_sequence_too(bench, if1):
    """Cancel: "This will stop any axis in motion"; it also ends the sequence that has handed over control."""
    write(if1, ":%:X20@400:$")
    bench.run(0.1)
    write(if1, "Y4000$")
    bench.run(1.0)
    write(if1, "#")
    bench.run(0.1)
    assert status(bench, if1, "E") == "C"
    y = positions(if1)[1]
    command(bench, if1, "%", seconds=1.0)
    assert positions(if1) == (0, y, 0) and 0 < y < 4000


@pytest.mark.parametrize("text", ["X10%$", "%X10$", "%$", "%%", "S1%"])
def test_percent_in_odd_places_is_a_data_fault(bench, if1, text):
    """R7: `%` anywhere else is a data fault, and the message moves nothing."""
    command(bench, if1, text, seconds=0.5)
    assert positions(if1) == (0, 0, 0) and not if1.pins["output1"].level
    assert number(bench, if1, "F") == 8


def test_with_echo_the_prompt_is_not_mixed_up_with_the_echo(bench):
    """Echo back: "each character is returned to the controller"; the prompt `%` is sent in addition to the echo."""
    if1 = ready(bench, "U62")
    assert (ask(bench, if1, ":X10@400:%:Y10:$"), ask(bench, if1, "Z5$")) == (b":X10@400:%:Y10:$\r%\r", b"Z5$\r")
    assert ask(bench, if1, "%") == b"%\r"
    bench.run(0.5)
    assert positions(if1) == (10, 10, 5)


def test_a_sequence_sent_in_a_hand_over_is_a_data_fault(bench, if1):
    """Intervention: "execute any move instruction it receives": a sequence within a sequence is a data fault."""
    write(if1, ":%:X10@400:$")
    bench.run(0.1)
    write(if1, ":Y5@400:Z5:$", ":$")
    bench.run(1.0)
    assert (positions(if1), number(bench, if1, "F")) == ((0, 0, 0), 8)
    command(bench, if1, "%", seconds=1.0)
    assert positions(if1) == (10, 0, 0)


@pytest.mark.parametrize("line", ["dtr", "rts"])
def test_a_prompt_that_is_cancelled_before_it_may_be_sent_leaves_rts_reset(bench, if1, line):
    """Control lines: RTS is "set prior to the start of transmission": a cancelled prompt resets RTS."""
    setattr(if1.serial.host, line, False)
    command(bench, if1, ":%:Y5:$", seconds=0.1)
    assert if1.serial.rts
    command(bench, if1, "#", seconds=0.1)
    assert not if1.serial.rts
    setattr(if1.serial.host, line, True)
    assert ask(bench, if1, "E") == b"C\r"
    assert not if1.serial.rts


def test_a_reply_that_waits_with_a_cancelled_prompt_keeps_rts_set(bench, if1):
    """Control lines: RTS stays set for another reply, which is sent as soon as DSR and CTS are set."""
    if1.serial.host.dtr = False
    command(bench, if1, ":%:Y5:$", "K", "#", seconds=0.1)
    assert if1.serial.rts
    if1.serial.host.dtr = True
    bench.run(0.1)
    assert if1.serial.read() == b"0\r" and not if1.serial.rts
