"""Sequence mode: controller intervention in a sequence, `%`."""

import pytest

from .helpers import gaps, number, positions, settle, status, strokes, times
from .talking import ask, ready, tell


def test_the_sequence_hands_over_and_resumes(bench, if1):
    """Intervention: after Y 400 it "transmits "% <CR>"" and "resumes with the negative Y move when "% <CR>""."""
    tell(if1, ": Y 400 @ 200 : % : Y- : $")
    bench.run(1.9)
    assert if1.serial.read() == b""
    bench.run(0.2)
    assert if1.serial.read() == b"%\r"
    assert positions(if1) == (0, 400, 0)

    tell(if1, "X150@400$")
    bench.run(60.0)
    assert positions(if1) == (150, 400, 0)
    tell(if1, "Z400@400$")
    settle(bench, if1)
    tell(if1, "%")
    settle(bench, if1)
    assert positions(if1) == (150, 0, 400)  # Y- by the distance given last
    assert strokes(if1.axes["Y"]) == [400, -400]


def test_the_prompt_comes_when_the_move_before_has_ended(bench, if1):
    """Intervention: "Following the Y move of 400 steps"."""
    tell(if1, ":Y400@200:%:$")
    heard: list[int] = []
    if1.serial.subscribe_received(lambda byte, errors: heard.append(bench.now))
    bench.run(3.0)
    # a character of 11 bits at 9600 baud takes 1.15 ms; the prompt follows the move within a few of them
    assert 0 < heard[0] - times(if1.axes["Y"])[-1] < 5_000_000


def test_the_prompt_ends_as_the_data_format_says(bench):
    """Intervention, Initialisation: in the V format <CR> "should be interpreted as representing <CR><LF>"."""
    if1 = ready(bench, "V61")
    tell(if1, ":%:X10@400:$", "\n")
    bench.run(0.2)
    assert if1.serial.read() == b"%\r\n"
    tell(if1, "%", "\r\n")
    bench.run(0.2)
    assert positions(if1) == (10, 0, 0)


def test_the_instruction_may_have_inputs_outputs_and_ramp_data(bench, if1):
    """ "combined with input and output commands, as well as acceleration rate and start/stop speed data"."""
    if1.pins["input1"].drive(False)
    tell(if1, ":X100@400:%:Y600@1000:$")
    bench.run(0.5)
    assert if1.serial.read() == b"%\r"
    tell(if1, "^20 <6")
    bench.run(1.2)
    tell(if1, "H1Z50@600S3$")
    bench.run(1.0)
    assert positions(if1)[2] == 0 and status(bench, if1, "E") == "E"
    if1.pins["input1"].drive(True)
    bench.run(0.2)
    assert positions(if1)[2] == 50 and if1.pins["output3"].level
    tell(if1, "%")
    settle(bench, if1)
    # start/stop 600, acceleration 20,000: levels 600, 700, 800, 900 of 5 ms: 3 + 3.5 + 4 + 4.5 = 15 pulses each way,
    # 570 at 1000 steps/s: from the start to the last pulse 20 + 570 + 20 ms, the first pulse after 1/600 s
    y = times(if1.axes["Y"])
    assert len(y) == 600
    assert y[-1] - y[0] == 610_000_000 - 1_666_666
    assert set(gaps(y[20:580])) == {1_000_000}


def test_parameters_alone_are_taken_too(bench, if1):
    """Intervention: data-dependent data: the host changes the speed and the distance, then lets go."""
    tell(if1, ":%:X:$")
    bench.run(0.1)
    tell(if1, "@100")
    bench.run(0.1)
    tell(if1, "Z25$")
    bench.run(1.0)
    tell(if1, "%")
    settle(bench, if1)
    assert positions(if1) == (25, 0, 25)
    assert set(gaps(times(if1.axes["X"]))) == {10_000_000}


def test_a_handed_over_interface_is_clear(bench, if1):
    """R20: "In a `%` hand-over with nothing moving: C"; moving, E; O names the `%` step."""
    tell(if1, ":S1:%:X10@400:$")
    bench.run(0.1)
    assert if1.serial.read() == b"%\r"
    assert (status(bench, if1, "E"), number(bench, if1, "K"), number(bench, if1, "O")) == ("C", 0, 2)
    tell(if1, "Y400$")
    assert (status(bench, if1, "E"), number(bench, if1, "K")) == ("E", 3)
    bench.run(2.0)
    assert status(bench, if1, "E") == "C"
    tell(if1, "%")
    settle(bench, if1)
    assert positions(if1) == (10, 400, 0)


def test_resuming_while_the_hosts_move_still_runs_waits_for_it(bench, if1):
    """Intervention: `%` sent right behind a move; the sequence goes on when the move is done."""
    tell(if1, ":%:X10:$")
    bench.run(0.1)
    tell(if1, "Y400@400$")
    tell(if1, "%")
    bench.run(0.5)
    assert positions(if1)[0] == 0
    bench.run(1.0)
    assert positions(if1) == (10, 400, 0)
    assert times(if1.axes["X"])[0] > times(if1.axes["Y"])[-1]


def test_each_pass_of_a_repeat_hands_over_anew(bench, if1):
    """Intervention within repeats: "where data-dependent moves must be included in a preset sequence"."""
    tell(if1, ":X10@400:%:=2,1:$")
    for moved in (1, 2, 3):
        bench.run(0.5)
        assert if1.serial.read() == b"%\r"
        tell(if1, f"Y{moved}$")
        bench.run(0.5)
        tell(if1, "%")
    bench.run(0.5)
    assert positions(if1) == (30, 6, 0)
    assert if1.serial.read() == b"" and status(bench, if1, "E") == "C"


def test_two_hand_overs_in_a_row(bench, if1):
    """Intervention: each `%` of the sequence needs a `%` of its own."""
    tell(if1, ":%:%:X10@400:$")
    bench.run(0.2)
    assert ask(bench, if1, "%") == b"%\r%\r"
    assert positions(if1) == (0, 0, 0)
    assert ask(bench, if1, "%") == b""
    assert positions(if1) == (10, 0, 0)


def test_cancel_in_a_hand_over_ends_the_sequence(bench, if1):
    """Repeating: "the cancel code ... terminates the sequence"; after that `%` resumes nothing."""
    tell(if1, ":X10@400:%:X20:$")
    bench.run(0.5)
    tell(if1, "#")
    bench.run(0.1)
    tell(if1, "%")
    bench.run(0.5)
    assert positions(if1) == (10, 0, 0)
    number(bench, if1, "F")
    tell(if1, ":$")
    bench.run(0.5)
    assert positions(if1) == (20, 0, 0)


def test_cancelling_the_hosts_own_move_ends_the_sequence_too(bench, if1):
    """Cancel: "This will stop any axis in motion", and a sequence that is handed over is a running one."""
    tell(if1, ":%:X20@400:$")
    bench.run(0.1)
    tell(if1, "Y4000$")
    bench.run(1.0)
    tell(if1, "#")
    bench.run(0.1)
    assert status(bench, if1, "E") == "C"
    y = positions(if1)[1]
    tell(if1, "%")
    bench.run(1.0)
    assert positions(if1) == (0, y, 0) and 0 < y < 4000


def test_percent_where_no_sequence_waits_moves_nothing(bench, if1):
    """Command list: `%` is "Wait for control"; without a hand-over there is nothing to resume."""
    tell(if1, "%")
    bench.run(0.1)
    assert positions(if1) == (0, 0, 0)
    tell(if1, ":X100@400:P0,50:Y10:$")
    bench.run(0.1)
    tell(if1, "%")
    bench.run(0.2)
    tell(if1, "%")
    bench.run(2.0)
    assert positions(if1) == (100, 10, 0)
    assert number(bench, if1, "F") == 8
    assert status(bench, if1, "E") == "C"


@pytest.mark.parametrize("text", ["X10%$", "%X10$", "%$", "%%", "S1%"])
def test_percent_in_odd_places_is_a_data_fault(bench, if1, text):
    """R7: a message that is no instruction moves nothing."""
    tell(if1, text)
    bench.run(0.5)
    assert positions(if1) == (0, 0, 0) and not if1.pins["output1"].level
    assert number(bench, if1, "F") == 8


def test_the_prompt_waits_for_the_handshake_and_the_sequence_with_it(bench, if1):
    """Control lines: "will therefore not transmit data until DSR and CTS are both set"; R4."""
    if1.serial.host.rts = False
    tell(if1, ":X10@400:%:Y10:$")
    bench.run(1.0)
    assert if1.serial.read() == b"" and positions(if1) == (10, 0, 0)
    if1.serial.host.rts = True
    bench.run(0.1)
    assert if1.serial.read() == b"%\r" and positions(if1) == (10, 0, 0)
    tell(if1, "%")
    settle(bench, if1)
    assert positions(if1) == (10, 10, 0)


def test_with_echo_the_prompt_is_not_mixed_up_with_the_echo(bench):
    """Echo back: "each character is returned to the controller"; the prompt is sent, not echoed."""
    if1 = ready(bench, "U62")
    assert ask(bench, if1, ":X10@400:%:Y10:$") == b":X10@400:%:Y10:$\r%\r"
    assert ask(bench, if1, "Z5$") == b"Z5$\r"
    assert ask(bench, if1, "%") == b"%\r"
    bench.run(0.5)
    assert positions(if1) == (10, 10, 5)


def test_a_status_request_in_a_hand_over_is_answered(bench, if1):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""
    tell(if1, ":%:X10@400:$")
    bench.run(0.1)
    assert if1.serial.read() == b"%\r"
    assert [status(bench, if1, letter) for letter in "KFIOEN"] == ["0", "0", "200", "1", "C", "0"]
    assert ask(bench, if1, "Q") == b"\0"
    tell(if1, "%")
    bench.run(0.2)
    assert positions(if1) == (10, 0, 0)


def test_a_fault_in_the_hosts_move_ends_the_sequence(bench, if1):
    """R22: a sequence ends with a fault, handed over or not."""
    tell(if1, ":%:X10@400:$")
    bench.run(0.1)
    tell(if1, "Y4000$")
    bench.run(0.5)
    if1.pins["estop"].drive(False)
    bench.run(0.5)
    if1.pins["estop"].release()
    assert number(bench, if1, "K") == 32
    tell(if1, "%")
    bench.run(0.5)
    assert positions(if1)[0] == 0


def test_a_sequence_sent_in_a_hand_over_is_a_data_fault(bench, if1):
    """Intervention: "execute any move instruction it receives"; a sequence within a sequence is none."""
    tell(if1, ":%:X10@400:$")
    bench.run(0.1)
    tell(if1, ":Y5@400:Z5:$")
    tell(if1, ":$")
    bench.run(1.0)
    assert positions(if1) == (0, 0, 0)
    assert number(bench, if1, "F") == 8
    tell(if1, "%")
    bench.run(1.0)
    assert positions(if1) == (10, 0, 0)


@pytest.mark.parametrize("line", ["dtr", "rts"])
def test_a_prompt_that_is_cancelled_before_it_may_be_sent_leaves_rts_reset(bench, if1, line):
    """Control lines: RTS is "set prior to the start of transmission": nothing is left to be transmitted."""
    setattr(if1.serial.host, line, False)
    tell(if1, ":%:Y5:$")
    bench.run(0.1)
    assert if1.serial.rts
    tell(if1, "#")
    bench.run(0.1)
    assert not if1.serial.rts
    setattr(if1.serial.host, line, True)
    assert ask(bench, if1, "E") == b"C\r"
    assert not if1.serial.rts


def test_a_reply_that_waits_with_a_cancelled_prompt_keeps_rts_set(bench, if1):
    """Control lines: what is left is sent as soon as DSR and CTS are set."""
    if1.serial.host.dtr = False
    tell(if1, ":%:Y5:$")
    tell(if1, "K")
    tell(if1, "#")
    bench.run(0.1)
    assert if1.serial.rts
    if1.serial.host.dtr = True
    bench.run(0.1)
    assert if1.serial.read() == b"0\r" and not if1.serial.rts
