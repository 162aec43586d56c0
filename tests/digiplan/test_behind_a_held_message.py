"""Report-back "at any time" and the cancel code while a message is held, a ramp is calculated or a reply is slow."""

import pytest

from ..scripts import scripts
from .talking import characters, play, ready


@pytest.mark.parametrize("typed", ["", "@9", "E", "EX5", "@99<CR>"])
def test_a_host_that_waits_for_each_echo_stops_the_motor(bench, typed):
    """Run mode: "To stop the motor, send the cancel code"; sample program 8 waits for the echo of each character."""
    if1 = ready(bench, "U62")
    play(bench, if1, "X@100G$; Y1$; 0.1 s; receives X@100G$<CR>Y1$<CR>")
    if1.serial.write(characters(typed))
    bench.run(0.1)
    assert if1.serial.read() in (b"", b"E")
    play(bench, if1, "moving; sends #; 0.05 s; receives #; moving; sends <CR>; 0.05 s; receives <CR>; still")
    play(bench, if1, "E<CR> -> E<CR>C<CR>; Y at 0")


@pytest.mark.parametrize(("form", "other", "end"), [("V61", "<CR>", "<LF>"), ("U61", "<LF>", "<CR>")])
@pytest.mark.parametrize("waits", ["XG$", "XG$; Y1$", "host DTR off; XG$; I"])
def test_the_cancel_code_needs_the_terminator_of_its_format(bench, form, other, end, waits):
    """Initialisation: in V "all following instructions must be terminated by <LF>"; U "expects only <CR>"."""
    said = "; ".join(f"sends {act}{end}" if act[0] in "XYI" else act for act in waits.split("; "))
    play(bench, ready(bench, form), f"{said}; 0.1 s; sends #{other}; 0.1 s; moving; sends {end}; 0.01 s; still")


@scripts({
    'Acceleration rate: it "calculates a new ramp ... and it will not respond during this period"':
    "X40$; ^20; Y20$; until X at 40; 0.1 s; E; 0.5 s; until Y moving; 0.02 s; receives E<CR>",
    'Report-back: "interrogated to establish its status at any time": an emergency stop within a request':
    "X@100G$; 0.1 s; Y1$; 0.1 s; sends E; 0.01 s; estop low; 0.01 s; sends <CR>; 0.05 s; receives F<CR>",
    'Report-back: "interrogated to establish its status at any time": a limit within a request':
    "X@100G$; 0.1 s; Y1$; 0.1 s; @99; sends K; 0.01 s; limit_plus low; 0.01 s; sends <CR>; 0.05 s; "
    "receives 64<CR>; Y-1$; 0.1 s; Y at -1",
    'Report-back: "interrogated to establish its status at any time": a request before `#` is answered after it':
    "D25; X@100G$; 0.1 s; Y1$; K; I; @99; O; #; 0.1 s; still; 4 s; receives 3<CR>200<CR>0<CR>; "
    "Y at 0",
    'Motion status: at 95 % "all the characters in the buffer will be lost", here with `#`; later moves are made':
    "D25; X@100G$; 0.1 s; I; 0.05 s; #; fill 62; 1.2 s; receives 200<CR>; still; Y5@400$; 0.5 s; Y at 5",
})  # fmt: skip
def test_requests_and_the_cancel_code(bench, if1, script):
    play(bench, if1, script)


def test_with_echo_and_a_delay_the_request_before_the_cancel_code_is_answered(bench):
    """Inter-character delay: with D25 the echo of E takes 250 ms, and `#` comes meanwhile."""
    play(bench, ready(bench, "U62"), "D25; 0.1 s; receives D25<CR>; X@100G$; 3 s; receives X@100G$<CR>; Y1$; 2 s; "
         "receives Y1$<CR>; E; 0.05 s; #; 0.01 s; 3 s; receives E<CR>C<CR>#<CR>; still; Y at 0")  # fmt: skip


def test_with_echo_and_a_delay_the_cancel_code_acts_before_its_own_echo(bench):
    """Run mode: "To stop the motor, send the cancel code"; with D25 its echo takes 500 ms."""
    play(bench, ready(bench, "U62"), "D25; 0.1 s; receives D25<CR>; X@100G$; 3 s; receives X@100G$<CR>; moving; #; "
         "0.01 s; still; 1 s; receives #<CR>")  # fmt: skip
