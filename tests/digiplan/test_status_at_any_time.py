"""Chapter Report-back functions: "The interface can be interrogated to establish its status at any time"."""

from ..scripts import scripts
from .talking import number, play, positions, ready

WAITING = "X40$; Y20$; @200; Z8$; "
"""A move, a move that is held, and two messages that wait in the buffer.  40 steps at 400 steps/s take 100 ms."""


@scripts({
    "Quick status: it is answered whatever messages wait before it":
    "X40$; Y20$; @200; Z8$; 0.05 s; Q; 0.02 s; receives \x03; X moving; 1 s; at 40 20 8; F: 0",
    # Y runs at 400; `@200` is for Z
    "Report-back: a request does not change the order of held messages":
    "X40$; E; Y20$; E; @200; E; Z8$; E; 0.06 s; receives E<CR>E<CR>E<CR>E<CR>; 1 s; Y 20 pulses at 400; "
    "Z 8 pulses at 200; at 40 20 8",
    # `>1` takes a second of calculation, during which all of it is received
    "Report-back: a request is answered even if it was in the buffer before the waiting message was read":
    ">1; 0.05 s; X40$; Y20$; @200; Z8$; E; until X moving; 0.02 s; receives E<CR>; X moving",
    "Lockout: `[` waits behind a held move, and the `]` that was sent after it is executed after it":
    "X40$; Y20$; [; ]; Z8$; 1 s; E: C; at 40 20 8",
    'Run mode: "send the cancel code": it discards all waiting messages, but not the answer being sent':
    "X40$; Y20$; @200; Z8$; E; #; Z3$; 1 s; receives E<CR>; X between 1 39; Y at 0; Z at 3",
    'Report-back: a request is answered "at any time", whatever messages wait before it':
    "X40$; Y20$; @200; Z8$; {K|I|O|E|F}: {3|200|0|E|0}; X moving; 1 s; at 40 20 8; F: 0",
})  # fmt: skip
def test_requests_between_waiting_messages(bench, if1, script):
    play(bench, if1, script)


def test_the_position_too(bench, if1):
    """Position report-back: "whilst an axis is in motion"; at or below the start/stop speed the answer is exact."""
    play(bench, if1, f"{WAITING}until X moving; 0.02 s")
    assert 0 < positions(if1)[0] <= number(bench, if1, "N") <= positions(if1)[0] < 40


def test_with_echo_a_request_is_echoed_and_answered(bench):
    """Echo back: each character is echoed when it has been processed; the reply follows the echo."""
    play(bench, ready(bench, "U62"), f"{WAITING}0.05 s; receives X40$<CR>Y20$<CR>; E; 0.02 s; "
         "receives E<CR>E<CR>; 1 s; receives @200<CR>Z8$<CR>; at 40 20 8")  # fmt: skip


def test_in_v_format_a_request_ends_in_a_line_feed(bench):
    """Initialisation: "all following instructions must be terminated by <LF>"; the carriage return is optional."""
    play(bench, ready(bench, "V61"), "sends X40$<LF>Y20$<LF>@200<LF>Z8$<LF>; 0.04 s; sends K<CR><LF>; 0.02 s; "
         "receives 3<CR><LF>; sends E<LF>; 0.02 s; receives E<CR><LF>; sends E; 0.02 s")  # fmt: skip


def test_a_request_makes_room_in_the_buffer(bench, if1):
    """Control of data transfer: an answered request leaves the buffer, so DTR is set again below 20 %."""
    play(bench, if1, "XG$; Y20$; @200; sends " + "K<CR>" * 30 + "; 0.5 s; receives " + "3<CR>" * 30 + "; F: 0")
    assert if1.serial.dtr
