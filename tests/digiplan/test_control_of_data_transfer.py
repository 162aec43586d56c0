"""Serial communication: the RS232C control lines, control of data transfer, alternative connection methods."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import arrivals, ask, command, edges, play, positions, ready, write

XOFF, XON = 0x13, 0x11


# The control lines


@scripts({
    'Control lines: both are outputs "set prior to the start of transmission"; RTS is set only to transmit':
    "0.001 s; DTR is on; RTS is off; 2 s; DTR is on; RTS is off",
    'Connection methods: "The interface will not transmit any data under these conditions"':
    "host DTR off; host RTS off; 1.5 s; sends (; 3 s; host DTR on; host RTS on; 0.1 s; receives U<CR>",
})  # fmt: skip
def test_control_lines_from_power_up_on(bench, script):
    play(bench, bench.add("if1"), script)


def test_rts_is_set_before_the_first_character_and_reset_after_the_last(bench, if1):
    """Control lines: "RTS and DTR are both outputs ... set prior to the start of transmission"."""
    bench.run(0.1)
    lines: list[tuple[int, bool]] = []
    if1.serial.rts_line.subscribe(lambda pin: lines.append((bench.now, pin.level)))
    received = arrivals(bench, if1)
    write(if1, "I")
    bench.run(0.1)
    assert [level for _, level in lines] == [True, False]
    assert lines[0][0] <= received[0][0] - 10 * S // 9600  # at the latest with its start bit
    assert lines[1][0] >= received[-1][0]


def test_rts_is_set_once_for_each_reply_on_a_line_without_transmission_times(bench):
    """Control lines: RTS is "set prior to the start of transmission" of a reply, and reset after it."""
    if1 = ready(bench, line="instant")
    seen: list[object] = []
    if1.serial.rts_line.subscribe(lambda pin: seen.append(pin.level))
    if1.serial.subscribe_received(lambda byte, _: seen.append(chr(byte)))
    play(bench, if1, "I<CR> -> 200<CR>; RTS is off")
    assert seen == [True, "2", "0", "0", "\r", False]


@pytest.mark.parametrize("wiring", ["5-wire", "Epson HX20 5-wire", "IBM PC 5-wire"])
@pytest.mark.parametrize("line", ["DTR", "RTS"])
def test_a_reply_waits_until_dsr_and_cts_are_set(bench, wiring, line):
    """Control lines: "will therefore not transmit data until DSR and CTS are both set".  R4: held, not lost.

    Appendix 3: "5-wire with buffer control".
    """
    script = f"host {line} off; E; 5 s; K; 5 s; host {line} on; 0.1 s; receives C<CR>0<CR>"
    play(bench, ready(bench, wiring=wiring), script)


@scripts({
    'Control lines: nothing is sent before "DSR and CTS are both set": both lines are needed':
    "host DTR off; host RTS off; E; 1 s; host DTR on; 1 s; host DTR off; host RTS on; 1 s; host DTR on; 0.1 s; "
    "receives C<CR>",
    "Control lines: RTS is set prior to the start of transmission, so a host can answer RTS by CTS":
    "host RTS off; E; 1 s; RTS is on; host RTS on; 0.1 s; receives C<CR>; RTS is off",
    "Control lines: they hold back what the interface transmits, not what it receives":
    "host RTS off; X9$; 0.5 s; X at 9",
    'Emergency stop: "inhibit all movement", whatever the serial line does':
    "host RTS off; XG$; E; 1 s; estop low; 0.01 s; X at rest",
    "Introduction: the interface generates the pulses by itself; outputs change at the end of the move":
    "host RTS off; X40S1$; E; 0.2 s; X at 40; output1 is high",
    'Motion status: "data fault or buffer overflow" is bit 8 of F; 61 of 64 places are 95 %':
    "X@100G$; 0.1 s; Y1$; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; @99; 0.1 s; "
    "sends @; 0.1 s; K: 131; F: 8; #",
})  # fmt: skip
def test_work_while_a_reply_is_held(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("line", ["dtr", "rts"])
def test_a_line_that_goes_away_holds_the_rest_of_the_reply(bench, line):
    """Control lines: if a line is reset during a reply, only characters that are already in the UART are sent."""
    if1 = ready(bench, line="110 8N2")
    write(if1, "I")
    bench.run_until(lambda: if1.serial.rts, 2)
    bench.run(0.05)  # half of the first character
    setattr(if1.serial.host, line, False)
    bench.run(5)
    begun = if1.serial.read()
    assert begun in (b"2", b"20")
    setattr(if1.serial.host, line, True)
    bench.run(1)
    assert begun + if1.serial.read() == b"200\r"


@pytest.mark.parametrize("wiring", ["3-wire", "3-wire DSR-DTR", "NEC PC-8201A", "Epson HX20 3-wire", "IBM PC 3-wire"])
def test_with_three_wires_the_hosts_lines_do_not_matter(bench, wiring):
    """Connection methods: "Where the controller cannot support the additional control lines, the 3-wire system".

    Appendix 3: "3-wire with or without echo-back".
    """
    script = "host DTR off; host RTS off; 1.5 s; ( -> U<CR>; U61; 1.2 s; I: 200; host RTS on; I: 200"
    play(bench, bench.add("if1", wiring=wiring), script)


# The 64-character input buffer: 80 %, 20 %, 95 %


@scripts({
    'Control of data transfer: "resets the DTR line if the buffer becomes 80% full": 52 of 64 (51.2)':
    "U61; ^10; 0.03 s; fill 51; DTR is on; fill 1; DTR is off",
    'Data fault: "95% full" is 61 of 64 characters (60.8), so 60 characters are kept':
    "U61; ^10; 0.03 s; X7$; fill 56; 1.5 s; X at 7; F: 0",
    'Data fault: "the input buffer is 95% full, in which case all the characters in the buffer will be lost"':
    "U61; ^10; 0.03 s; X7$; fill 57; DTR is on; 1.5 s; X at 0; K: 128; F: 8; K: 0; F: 0",
    "Data fault: the characters in the buffer are lost, not those after them":
    "U61; ^10; 0.03 s; X7$; fill 57; Y5$; 1.5 s; at 0 5 0",
    'Control of data transfer: characters sent "more rapidly than they can be processed ... will accumulate"':
    "U61; H1X5$; S1$; @200; 0.1 s; DTR is on; fill 52; DTR is off; input1 high; 0.5 s; DTR is on; output1 is high; "
    "F: 0",
    "Control of data transfer: the loss empties the buffer, so X-on is sent; without it the host would wait":
    "U67; ^10; 0.03 s; fill 61; receives <13>; 0.05 s; receives <11>",
    "Control lines: X-off waits until DSR and CTS are both set, like everything that is transmitted":
    "U67; ^10; 0.03 s; host RTS off; fill 53; 0.1 s; host RTS on; 0.01 s; receives <13>",
    "Control of data transfer: the manual does not say that it obeys X-off: one from the host is a data fault":
    "U67; sends <13>; 0.1 s; sends <CR>; 0.1 s; F: 8",
})  # fmt: skip
def test_the_input_buffer_of_64_characters(bench, script):
    """Each script begins with the data format message; ^10 calculates a ramp, and for a second nothing is read."""
    message, _, acts = script.partition("; ")
    play(bench, ready(bench, message), acts)


LEFT = "^10; 0.03 s; sends {}^20<CR>; fill {}"
"""A ramp calculation, 52 characters in the buffer, and a second calculation that leaves a number of them."""


def leave(characters: int) -> str:
    return LEFT.format("<SP>" * (52 - 4 - characters), characters)


@pytest.mark.parametrize(("left", "dtr"), [(14, "off"), (13, "off"), (12, "on"), (11, "on")])
def test_dtr_is_set_again_below_20_percent(bench, if1, left, dtr):
    """Control of data transfer: "DTR is set again when the buffer has become less than 20% full": 12 of 64 (12.8)."""
    play(bench, if1, f"{leave(left)}; DTR is off; 1.2 s; DTR is {dtr}; 1.2 s; DTR is on; F: 0")


def test_a_buffer_that_was_never_80_percent_full_does_not_touch_dtr(bench, if1):
    """Control of data transfer: DTR is reset only when the buffer is 80 % full, and never before."""
    changes = edges(if1.serial.dtr_line)
    play(bench, if1, "^10; 0.03 s; fill 51; 1.5 s")
    assert changes == []


def test_it_transmits_while_dtr_is_reset(bench, if1):
    """Control lines: DTR is "set prior to the start of transmission"; its reset stops the host, not the replies."""
    seen = []
    if1.serial.subscribe_received(lambda byte, _: seen.append((chr(byte), if1.serial.dtr)))
    play(bench, if1, "D25; 0.1 s; I; 0.3 s; receives 2; fill 52; 1.5 s; receives 00<CR>; DTR is on")
    assert seen == [("2", True), ("0", False), ("0", False), ("\r", True)]  # while the <CR> leaves, the blanks are read


# X-on, X-off


@pytest.mark.parametrize("parity", [7, 8, 9])
def test_x_off_is_sent_at_80_percent_and_x_on_at_20(bench, parity):
    """Control of data transfer: "an X-off character (13 Hex) is transmitted ... When ... 20% full, X-on (11 Hex)"."""
    once = "^10; 0.03 s; fill 51; 0.01 s; fill 1; 0.01 s; receives <13>; fill 3; 0.01 s; 1.2 s; receives <11>"
    play(bench, ready(bench, f"U6{parity}"), once)


@pytest.mark.parametrize(("left", "sent"), [(13, "1.2 s; 1.2 s; receives <11>"), (12, "1.2 s; receives <11>; 1.2 s")])
def test_x_on_is_sent_below_20_percent_and_not_before(bench, left, sent):
    """Control of data transfer: X-on is sent when fewer than 20 %, that is 12 of 64 characters, are left."""
    play(bench, ready(bench, "U67"), f"{leave(left)}; 0.01 s; receives <13>; {sent}")


@pytest.mark.parametrize("parity", [1, 2, 3, 4, 5, 6])
def test_the_other_formats_send_no_x_off(bench, parity):
    """Initialisation, table: only X2 = 7, 8 and 9 have X-on and X-off."""
    echo = f"receives ^10<CR>{'<SP>' * 55}" if parity in (2, 5, 6) else "0 s"
    play(bench, ready(bench, f"U6{parity}"), f"sends ^10<CR>{'<SP>' * 55}; 2 s; {echo}")


# Overrun


def distinct_slots(characters: int, bits: int, strobe: int) -> int:
    """Return how many strobes find a character; `strobe` and `bits` are the periods of both in bit times."""
    return len({n * bits // strobe for n in range(characters)})


def test_safe_up_to_2400_baud(bench):
    """Control of data transfer: "characters can be transmitted safely at speeds up to 2400 baud"."""
    if1 = ready(bench, "U11", line="2400 8N2")  # 9 bits, the shortest character: 3.75 ms
    for _ in range(20):
        if1.serial.write(b" " * 50)
        bench.run_until(lambda: not if1.serial.pending, 10)
    bench.run(0.1)
    assert ask(bench, if1, "F") == b"0\r"


def test_above_2400_baud_a_character_can_be_overwritten(bench):
    """Overrun error: "set when the first character has not been read before the next one becomes available".

    At 9600 baud a 9-bit character comes every 0.9375 ms: 33 characters meet 31 strobes, so two are overwritten.
    """
    if1 = ready(bench, "U12", line="9600 8N2")
    sent = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ2345678"
    assert distinct_slots(33, 9375, 10000) == 31
    if1.serial.write(sent)
    bench.run(0.2)
    echo = if1.serial.read()
    assert len(echo) == 31
    rest = iter(sent)
    assert all(byte in rest for byte in echo)  # in order, with two characters missing
    for character in "#\rF":
        write(if1, character, end="")
        bench.run(0.01)
    if1.serial.read()
    assert ask(bench, if1, "") == b"\r2\r"


def test_the_overwritten_character_is_the_earlier_one(bench):
    """Control of data transfer: characters lost "by being overwritten before they get transferred to the buffer"."""
    if1 = ready(bench, "U62", line="9600 8N2", strobe_ms=5)
    bench.run_until(lambda: bench.now % (5 * MS) == 0, 0.1)
    if1.serial.write(b"1234")
    bench.run(0.1)
    assert if1.serial.read()[-1:] == b"4"


def test_a_slower_strobe_loses_11_bit_characters_too(bench):
    """Control of data transfer: "approximately 1mS"; in 1.25 ms = 12 bits, 25 characters of 11 bits meet 23 strobes."""
    if1 = ready(bench, "U62", line="9600 8N2", strobe_ms=1.25)
    assert distinct_slots(25, 11, 12) == 23
    if1.serial.write(b"ABCDEFGHIJKLMNOPQRSTUVWXY")
    bench.run(0.2)
    assert (len(if1.serial.read()), ask(bench, if1, "#"), ask(bench, if1, "F")) == (23, b"#\r", b"F\r2\r")


def test_echo_back_makes_9600_baud_safe(bench):
    """Connection methods: "Echo-back must be implemented if higher baud rates are to be used"."""
    if1 = ready(bench, "U12", line="9600 8N2")
    obedient_echo_host(bench, if1, "X123$\r" * 20)
    bench.run(2)
    assert if1.axes["X"].position == 2460
    obedient_echo_host(bench, if1, "F\r")
    bench.run(0.1)
    assert if1.serial.read() == b"0\r"


def obedient_echo_host(bench: Bench, if1: Controller, text: str) -> None:
    """Send each character after the echo of the previous one."""
    received = arrivals(bench, if1)
    for n, character in enumerate(text, start=1):
        write(if1, character, end="")
        assert bench.run_until(lambda n=n: len(received) == n, 5) and received[-1][1] == ord(character)
    if1.serial.read()


# Which connection for what: the two charts


def obedient_dtr_host(if1: Controller) -> Callable[[], None]:
    """A host that "should therefore interrupt data transmission if this signal becomes reset"."""

    def obey(_: object) -> None:
        if1.serial.held = not if1.serial.dtr

    return if1.serial.dtr_line.subscribe(obey)


def obedient_xon_host(if1: Controller) -> Callable[[], None]:
    """A host that stops at X-off and continues at X-on."""

    def obey(byte: int, _: object) -> None:
        if byte in (XOFF, XON):
            if1.serial.held = byte == XOFF

    return if1.serial.subscribe_received(obey)


WIRINGS = ("3-wire", "5-wire")
LONG = "^10\r" + "X1$Y1$".replace("$", "$\r") * 25  # 204 characters, of which the first four start a calculation


@pytest.mark.parametrize("baud", [1200, 2400])
def test_at_1200_and_2400_baud_a_longer_string_overflows_a_host_that_does_not_look(bench, baud):
    """Connection methods: "strings of more than 64 characters ... the DTR output must be monitored"."""
    if1 = ready(bench, line=f"{baud} 8N2")
    command(bench, if1, LONG, seconds=5, end="")
    assert if1.axes["X"].position < 25 and int(ask(bench, if1, "F")) & 8


def takes_no_notice(_: Controller) -> None:
    """A host that obeys neither DTR nor X-off."""


@pytest.mark.parametrize(
    ("host", "message", "baud", "wiring", "text", "x_y"),
    [*((takes_no_notice, "U61", baud, wiring, LONG, (25, 25)) for baud in (110, 300, 600) for wiring in WIRINGS),
     *((takes_no_notice, "U61", baud, "5-wire", LONG[: 4 + 8 * 7] + "X$\r", (8, 7)) for baud in (1200, 2400)),  # 63
     *((obedient_dtr_host, "U61", baud, "5-wire", LONG, (25, 25)) for baud in (1200, 2400, 9600)),
     *((obedient_xon_host, "U67", baud, "3-wire", LONG, (25, 25)) for baud in (1200, 2400))],
)  # fmt: skip
def test_a_host_loses_nothing_when_it_does_what_the_charts_ask_for(bench, host, message, baud, wiring, text, x_y):
    """Charts: up to 600 baud, "any" string, no echo-back, no need to check DTR.

    Charts: 1200 or 2400 baud, strings of less than 64 characters, no echo-back.  Charts, 5-wire: no echo-back, "need to
    check DTR? yes".  X-on, X-off: "very useful ... since only a simple 3-wire connection is required".
    """
    if1 = ready(bench, message, line=f"{baud} 8N2", wiring=wiring)
    host(if1)
    write(if1, text, end="")
    bench.run(40 if baud <= 600 else 10)
    if1.serial.read()
    assert (positions(if1), ask(bench, if1, "F", 1)) == ((*x_y, 0), b"0\r")


@pytest.mark.parametrize("baud", [1200, 4800, 9600])
def test_a_host_that_waits_for_the_echo_loses_nothing(bench, baud):
    """Connection methods: "if echo-back is used it is unnecessary to monitor the DTR line"."""
    if1 = ready(bench, "U62", line=f"{baud} 8N2", wiring="3-wire", strobe_ms=1.7)
    changes: list[bool] = []
    if1.serial.dtr_line.subscribe(lambda pin: changes.append(pin.level))
    obedient_echo_host(bench, if1, LONG)
    bench.run(1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (25, 25)
    assert (ask(bench, if1, "F"), changes) == (b"F\r0\r", [])


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.sampled_from(["X1$", "^10", "Y2$", "   ", "@300", "S1$", "R1$", "<4", ""]), max_size=40), st.booleans()
)
def test_whatever_is_sent_an_obedient_host_never_overflows_the_buffer(messages, echo):
    """Control of data transfer: a host that obeys DTR, or X-off and X-on, never overflows the buffer."""
    bench = Bench()
    if1 = ready(bench, "U67" if echo else "U61", line="2400 8N2")
    (obedient_xon_host if echo else obedient_dtr_host)(if1)
    for message in messages:
        write(if1, message)
    bench.run(60)
    assert if1.axes["X"].position == messages.count("X1$")
    assert if1.axes["Y"].position == 2 * messages.count("Y2$") and ask(bench, if1, "F")[-2:] == b"0\r"


def test_x_off_goes_before_the_rest_of_a_reply_and_without_the_delay(bench):
    """Inter-character delay: "inserted before each transmitted character", except X-off, which would be too late."""
    if1 = ready(bench, "U67")
    received = arrivals(bench, if1)
    play(bench, if1, "D25; 0.1 s; I; 0.3 s; receives 2")  # 200 <CR>, a character each 0.25 s
    filled_ns = bench.now
    play(bench, if1, "sends " + "<SP>" * 52 + "; 2 s; receives <13>00<CR><11>")
    assert received[1][0] - filled_ns < 52 * 1_200_000 + 10_000_000


@pytest.mark.parametrize("line", ["DTR", "RTS"])
@pytest.mark.parametrize("said", ["K<CR>", ":%:$<CR>", ">1<CR>" + "0" * 55])
def test_what_waits_for_dsr_and_cts_is_gone_with_the_power(bench, line, said):
    """Control lines: it "will not transmit data until DSR and CTS are both set"; then its power is off.

    The waiting characters are a reply, the prompt of a sequence, or the X-off of a buffer that is 80 % full.
    """
    off = f"host {line} off; sends {said}; 0.2 s; RTS is on; power off; 0.1 s; host {line} on; 0.1 s; RTS is off; "
    play(bench, ready(bench, "U67"), off + "power on; host 8N2; detect")  # U and CR, and nothing before them


def test_an_x_off_that_waits_when_the_power_goes_does_not_come_after_it(bench):
    """Control of data transfer: the buffer is empty after power-up, so a waiting X-off is not sent."""
    cycle = "host RTS off; >1; fill 55; power off; power on; 1.2 s; host RTS on; 0.1 s; host 8N2; "
    play(bench, ready(bench, "U67"), cycle + "detect; U61; 1.3 s; K: 0")


def test_what_follows_a_held_message_accumulates_in_the_buffer(bench, if1):
    """Control of data transfer: characters "will accumulate in the input buffer"; DTR is reset at 80 % of 64.

    `Y1$` is held behind a run; twelve messages of four characters follow, and four characters more.
    """
    play(bench, if1, "X@100G$; 0.1 s; Y1$; " + "@99; " * 12 + "0.1 s")
    assert if1.serial.dtr
    play(bench, if1, "@99; 0.02 s")
    assert not if1.serial.dtr
    play(bench, if1, "#; 0.1 s; F: 0; E: C; Y at 0")  # `#` empties the buffer before it
    assert if1.serial.dtr


def test_the_cancel_code_acts_at_once_behind_a_slow_answer(bench, if1):
    """Run mode: "To stop the motor, send the cancel code"; with D25 an answer of five characters takes 1.25 s.

    From 2000 steps/s the ramp has 1900, 1800 ... 400 steps/s for 10 ms each: 184 steps.  The code and its transfer
    to the buffer take at most 4 ms, 8 steps.
    """
    play(bench, if1, "D25; X@2000G$; 1 s; N; 0.05 s")
    begun = positions(if1)[0]
    write(if1, "#")
    bench.run(2)
    assert 184 <= positions(if1)[0] - begun <= 192
    play(bench, if1, "receives 1792<CR>; still")
