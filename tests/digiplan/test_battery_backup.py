"""Using the battery backup: the IF2 keeps a locked sequence and its data without power."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim import UartFormat
from axistwin.units import MS, S

from .talking import (
    ask,
    command,
    constant,
    detect,
    each_character,
    edges,
    host_format,
    moves,
    number,
    play,
    positions,
    pulse_times_of,
    ramped,
    ready,
    scripts,
    send,
    since_start,
    status,
    status_word,
    until_idle,
    write,
)

STORED = ":H1:X100@400:Y50:$"


def stored(bench: Bench, sequence: str = STORED, form: str = "U61", **options: object) -> Controller:
    """Return an IF2 with a locked sequence and its power off."""
    if2 = ready(bench, form, "if2", **options)
    end = "\n" if form[0] == "V" else "\r"
    write(if2, sequence, end=end)
    bench.run(0.1)
    write(if2, "[", end=end)
    bench.run(0.2)
    if2.power(False)
    if2.serial.read()
    return if2


def power_up(bench: Bench, if2: Controller, dsr: bool) -> None:
    """Switch on in a 5-wire system with DSR (the host's DTR) at `dsr`; then set DSR, so that answers are sent."""
    if2.serial.host.dtr = dsr
    if2.power(True)
    bench.run(1.05)
    if2.serial.host.dtr = True


# Running the stored sequence


def test_the_stored_sequence_starts_at_power_up_with_dsr_low(bench):
    """Running: "A switch input may be used to start the stored sequence at power-up"."""
    if2 = stored(bench)
    assert positions(if2) == (0, 0, 0)
    power_up(bench, if2, dsr=False)
    bench.run(2.0)
    assert positions(if2) == (0, 0, 0)
    assert (number(bench, if2, "O"), status(bench, if2, "E")) == (1, "[")
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert (positions(if2), number(bench, if2, "O")) == ((100, 50, 0), 3)


def test_a_sequence_that_begins_without_an_input_runs_at_once(bench):
    """Storing: ":H1:" "prevents the interface from executing the sequence at power-up"; without it, it runs."""
    if2 = stored(bench, ":X100@400:Y50:$")
    bench.run(3.0)
    before = positions(if2)
    if2.serial.host.dtr = False
    on_ns = bench.now
    if2.power(True)
    bench.run(3.0)
    x, y, _ = positions(if2)
    assert (x - before[0], y - before[1]) == (100, 50)
    # after the self-test of about 1 s; the manual does not say whether a ramp is calculated first
    first_ns = int(if2.axes["X"].pulse_times(on_ns)[0])
    assert 1 * S <= first_ns - on_ns <= 2 * S + 10 * MS


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_without_the_lock_command_the_sequence_is_lost(bench, model):
    """Storing: the lock command "must then be sent before power-down, otherwise the sequence data will be lost"."""
    card = ready(bench, model=model)
    command(bench, card, STORED, seconds=0.1)
    card.power(False)
    power_up(bench, card, dsr=False)
    card.pins["input1"].drive(True)
    bench.run(5.0)
    assert (positions(card), send(bench, card, "(", seconds=0.1, end="")) == ((0, 0, 0), b"U\r")


def test_an_if1_keeps_nothing_even_when_locked(bench):
    """R31: "works, but nothing survives power off": the IF1 has no battery."""
    if1 = ready(bench)
    if1.pins["input1"].drive(False)
    command(bench, if1, STORED, "[", seconds=0.1)
    if1.power(False)
    power_up(bench, if1, dsr=False)
    if1.pins["input1"].drive(True)
    bench.run(3.0)
    assert positions(if1) == (0, 0, 0)
    if1.serial.write(b"(")
    bench.run(0.1)
    send(bench, if1, "U61", seconds=1.5)
    assert (number(bench, if1, "F"), status(bench, if1, "E")) == (0, "C")


def test_the_speed_data_and_the_ramp_are_kept_too(bench):
    """Battery backup: "enables any data or sequence sent to the interface to be stored"."""
    if2 = ready(bench, model="if2")
    command(bench, if2, ">2 <6 ^20", seconds=1.2)
    for text in ("B-30", "P1,7$", "X700@3000$", ":H1:XB:P2:$"):
        write(if2, text)
    bench.run(3.0)
    command(bench, if2, "[", seconds=0.1)
    assert positions(if2) == (700, 0, 0)
    if2.power(False)
    bench.run(1_000_000.0)
    power_up(bench, if2, dsr=False)
    pulse = edges(if2.pins["output2"])
    if2.pins["input1"].drive(True)
    bench.run(5.0)
    assert moves(if2.axes["X"]) == [700, 730, -30]
    assert pulse[1][0] - pulse[0][0] == 70 * MS
    forth = if2.axes["X"].train.moves[-2]
    told = [int(at_ns) - forth.start_ns for at_ns in if2.axes["X"].pulse_times(forth.start_ns)][:730]
    # range 2: start/stop 600, increment 200, every 200/20000 s = 10 ms
    assert told == pulse_times_of(ramped(730, 600, 3000, 200, 20_000))
    assert since_start(if2.axes["X"]) == constant(600, 30)


def test_the_inter_character_delay_is_kept(bench):
    """Battery backup: "any data" is stored, the inter-character delay too."""
    if2 = ready(bench, model="if2")
    command(bench, if2, "D10", "[", seconds=0.5)
    if2.power(False)
    power_up(bench, if2, dsr=False)
    heard: list[int] = []
    if2.serial.subscribe_received(lambda byte, errors: heard.append(bench.now))
    assert send(bench, if2, "F", seconds=1.0) == b"32\r"
    assert heard[1] - heard[0] >= 100 * MS


def test_the_baud_rate_and_the_format_are_kept(bench):
    """Running, condition 2: "the same baud rate and data format as defined by the "U" and "V" commands"."""
    if2 = bench.add("if2", line="1200 8N2")
    detect(bench, if2)
    write(if2, "V22", end="\r\n")  # 7 bits, 2 stop bits, no parity, echo
    bench.run(0.2)
    host_format(if2, "V22")
    bench.run(1.2)
    assert ask(bench, if2, "[", end="\n") == b"[\n"
    if2.power(False)
    power_up(bench, if2, dsr=False)
    assert ask(bench, if2, "E", 0.5, "\n") == b"E\n[\r\n"


def test_the_positions_of_the_machine_stay_when_the_power_goes(bench):
    """Ruling 6: "Positions of axes are the bench's and survive a power cycle"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(0.15)
    stands = positions(if2)[0]
    assert 0 < stands < 100
    if2.power(False)
    bench.run(5.0)
    assert positions(if2) == (stands, 0, 0)
    power_up(bench, if2, dsr=False)
    bench.run(1.0)
    assert positions(if2) == (stands + 100, 50, 0)  # the sequence begins with its first step


def test_the_outputs_are_off_when_the_power_comes_back(bench):
    """Default values: "Outputs 1-5 - Off": levels of outputs are not among the stored data."""
    if2 = stored(bench, ":S135:H1:R1:$")
    bench.run(0.1)
    levels = [edges(if2.pins[f"output{n}"]) for n in (1, 2)]
    assert [if2.pins[f"output{n}"].level for n in range(1, 6)] == [False] * 5
    power_up(bench, if2, dsr=False)
    bench.run(1.0)
    assert [if2.pins[f"output{n}"].level for n in range(1, 6)] == [True, False, True, False, True]
    assert [len(seen) for seen in levels] == [1, 0]


# What can be said to a locked interface


@pytest.mark.parametrize("wiring", ["3-wire", "5-wire"])
def test_status_requests_only(bench, wiring):
    """Running: "restricted to status request codes only, and any other command instructions will be ignored"."""
    if2 = stored(bench, wiring=wiring)
    power_up(bench, if2, dsr=False)
    assert [status(bench, if2, letter) for letter in "KFIOEN"] == ["0", "32", "200", "1", "[", "0"]
    for text in ("X100$", "#", ":X10:$", "@200", "S1$", "*", "U61"):
        write(if2, text)
    bench.run(1.0)
    assert positions(if2) == (0, 0, 0) and if2.serial.read() == b""
    assert (number(bench, if2, "O"), number(bench, if2, "F")) == (1, 32)
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if2) == (100, 50, 0)


def test_3_wire_with_dsr_linked_to_cts_and_rts_counts_as_low(bench):
    """Running, condition 1: "In a 3-wire system this can be achieved by linking DSR to CTS and RTS"."""
    if2 = stored(bench, wiring="3-wire")
    if2.power(True)  # the levels of the host's lines do not matter
    bench.run(1.05)
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert (positions(if2), ask(bench, if2, "E")) == ((100, 50, 0), b"[\r")


@scripts(
    {
        'Control lines: "will therefore not transmit data until DSR and CTS are both set"; R4: held, not lost':
        "host DTR off; power on; 1.05 s; E; 0.2 s; host DTR on; 0.1 s; receives [<CR>",
        "A switch that is already on or off: power on and off twice is no different from once":
        "power off; host DTR off; power on; 1.05 s; input1 high; 0.1 s; power on; 1 s; at 100 50 0",
    }
)  # fmt: skip
def test_power_switched_with_dsr_low(bench, script):
    play(bench, stored(bench), script)


def test_no_error_checking_while_locked_up(bench):
    """Running: "No communication error checking is carried out whilst the interface is locked up"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.serial.host.baudrate = 300
    command(bench, if2, "UUU", seconds=0.5)
    if2.serial.host.baudrate = 9600
    command(bench, if2, "", "nonsense", seconds=0.1)
    assert (status_word(bench, if2), number(bench, if2, "F")) == (0, 32)
    command(bench, if2, "]", "nonsense", seconds=0.1)
    assert (status_word(bench, if2), number(bench, if2, "F")) == (128, 8)


def test_unlocked_after_power_up_it_obeys_again(bench):
    """Changing: "it is first necessary to unlock the interface", at the same baud rate and data format as before."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    write(if2, "]")
    assert status(bench, if2, "E") == "E"  # the stored sequence still waits for input 1
    write(if2, "#")
    assert status(bench, if2, "E") == "C"
    write(if2, "Z30$")
    until_idle(bench, if2)
    assert positions(if2) == (0, 0, 30)
    if2.pins["input1"].drive(True)
    write(if2, ":$")
    until_idle(bench, if2)
    assert positions(if2) == (100, 50, 30)


def test_changing_the_sequence_data(bench):
    """Changing: unlock, "the cancel code "# <CR>" followed by the new sequence data"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    for text in ("]", "#", ":H1:Z77@400:$", "["):
        write(if2, text)
    bench.run(0.2)
    assert status(bench, if2, "E") == "["
    if2.power(False)
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if2) == (0, 0, 77)


def test_unlocked_and_switched_off_all_is_lost(bench):
    """Storing: an unlocked sequence is lost without power."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    command(bench, if2, "]", seconds=0.1)
    if2.power(False)
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(2.0)
    assert (positions(if2), ask(bench, if2, "E")) == ((0, 0, 0), b"")
    assert send(bench, if2, "(", seconds=0.1, end="") == b"U\r"


def test_an_emergency_stop_is_reset_by_removing_the_power(bench):
    """Running: "If an emergency stop input is received ... power must be temporarily removed in order to reset"."""
    if2 = stored(bench, ":H1:X100@400:=0,2:$")
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    if2.pins["estop"].drive(False)
    bench.run(0.5)
    if2.pins["estop"].release()
    stands = positions(if2)
    for _ in range(3):
        assert status_word(bench, if2) == 32
    bench.run(5.0)
    assert positions(if2) == stands and if2.pins["led"].level
    if2.power(False)
    power_up(bench, if2, dsr=False)
    bench.run(1.0)
    assert positions(if2)[0] > stands[0] + 300
    assert not if2.pins["led"].level


# DSR high: a new data format


@pytest.mark.parametrize("wiring", ["5-wire", "3-wire DSR-DTR"])
def test_with_dsr_high_the_format_is_set_anew_and_starts_the_sequence(bench, wiring):
    """Changing: "DSR line must be held active"; "start to execute ... as soon as the "U" or "V" command"."""
    if2 = stored(bench, ":X100@400:Y50:$", wiring=wiring)
    bench.run(3.0)
    before = positions(if2)
    power_up(bench, if2, dsr=True)
    bench.run(5.0)
    assert positions(if2) == before
    assert ask(bench, if2, "E") == b""
    if2.serial.host.baudrate = 1200
    assert send(bench, if2, "(", end="") == b"U\r"
    assert positions(if2) == before
    command(bench, if2, "V62", seconds=3.0, end="\r\n")
    assert tuple(b - a for a, b in zip(before, positions(if2), strict=True)) == (100, 50, 0)
    assert ask(bench, if2, "E", 0.5, "\n") == b"E\n[\r\n"  # still locked
    # Changing: `]` "at same baud rate and data format as the previous lock command", which was 9600 and no other
    assert (ask(bench, if2, "]", 0.5, "\n"), ask(bench, if2, "E", 0.5, "\n")) == (b"]\n", b"E\n[\r\n")


def test_the_unlock_command_in_the_new_format_where_that_is_asked_for(bench):
    """Lockout: "However, it is possible to re-initialise the interface with a different data format"."""
    if2 = stored(bench, unlock="any format")
    power_up(bench, if2, dsr=True)
    if2.serial.host.baudrate = 1200
    if2.serial.write(b"(")
    bench.run(0.2)
    write(if2, "V61", end="\r\n")
    bench.run(1.0)
    assert ask(bench, if2, "]", 0.5, "\n") == b"U\r"
    assert ask(bench, if2, "E", 0.5, "\n") == b"E\r\n"  # the stored sequence waits for input 1


def test_the_new_format_is_kept_as_the_old_one_was(bench):
    """Changing: "The baud rate and data format can be reprogrammed even if the interface is in the locked-up mode"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=True)
    if2.serial.host.baudrate = 300
    if2.serial.write(b"(")
    bench.run(0.3)
    write(if2, "V61", end="\n")
    bench.run(2.0)
    if2.power(False)
    if2.serial.read()
    power_up(bench, if2, dsr=False)
    assert ask(bench, if2, "E", 0.5, "\n") == b"[\r\n"


@pytest.mark.parametrize("baudrate", [110, 300, 600, 1200, 2400, 4800, 9600])
def test_the_bracket_breaks_in_without_a_power_cycle_while_dsr_is_held(bench, baudrate):
    """Breaking in: "issue the open bracket "(" followed by the erase command", here without a power cycle."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    assert status(bench, if2, "E") == "["  # it runs the stored sequence, and waits for input 1
    if2.serial.host.baudrate = baudrate
    assert send(bench, if2, "(", seconds=0.5, end="") == b"U\r"
    assert send(bench, if2, "*", seconds=0.5, end="") == b"U\r"
    command(bench, if2, "U61", seconds=3.0)
    if2.pins["input1"].drive(True)
    assert ask(bench, if2, "E", 1.0) == b"C\r"
    assert positions(if2) == (0, 0, 0)  # the sequence is erased


@pytest.mark.parametrize("lock", [2400, 4800, 9600])
def test_nothing_else_that_a_host_says_is_taken_for_a_bracket_at_another_baud_rate(bench, lock):
    """Lockout: "it will respond to status request commands"; at another baud rate only `(` is accepted."""
    if2 = bench.add("if2")
    if2.serial.host.baudrate = lock
    bench.run(1.1)
    if2.serial.write(b"(")
    bench.run(0.1)
    write(if2, "U31")
    bench.run(1.2)
    send(bench, if2, "[", seconds=0.1)
    for byte in (*range(1, ord("(")), *range(ord("(") + 1, 128)):
        if2.serial.write(bytes([byte]))
        bench.run(0.02)
    send(bench, if2, "", seconds=0.1)
    assert status(bench, if2, "E") == "["


@pytest.mark.parametrize("form", ["U11", "U13", "U14", "U63", "U64", "U33", "U71"])
def test_the_bracket_breaks_in_whatever_the_format_of_the_lock_command(bench, form):
    """Breaking in: the host need not know the format of the lock command; it may have 8 bits and no parity."""
    if2 = stored(bench, form=form)
    host = if2.serial.host
    locked_in = host.format
    power_up(bench, if2, dsr=False)
    assert status_of_7_bits(bench, if2, "E") == "["
    for way in (UartFormat(9600, 8, "N", 2), UartFormat(2400, 8, "N", 1), UartFormat(1200, 7, "E", 1)):
        host.format = way
        if2.serial.write(b"(")
        bench.run(0.1)
        assert status_of_7_bits(bench, if2, "") == "U", way
        each_character(bench, if2, form + "\r", lambda n: bench.run(0.02))
        host_format(if2, form)
        bench.run(1.2)
        if2.serial.read()
    host.format = locked_in


def test_breaking_in_and_the_data_format_in_one_go(bench):
    """Changing: `(` and a data format end the waiting sequence before the same instant starts it again."""
    if2 = stored(bench, line="instant")
    power_up(bench, if2, dsr=False)
    assert send(bench, if2, "(U61", seconds=0.1) == b"U\r"
    assert if2.busy
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if2) == (100, 50, 0)
    assert not if2.busy


def test_a_lock_behind_a_held_move_is_kept_and_unlocked_as_any_other(bench):
    """Lockout: a lock command held behind a move is unlocked in the format in which it was received."""
    if2 = ready(bench, model="if2")
    for text in ("X40$", "Y20$", "["):
        write(if2, text)
    bench.run(1.0)
    assert status(bench, if2, "E") == "["
    if2.power(False)
    power_up(bench, if2, dsr=False)
    assert status(bench, if2, "E") == "["
    write(if2, "]")
    assert status(bench, if2, "E") == "C"


def status_of_7_bits(bench, controller, letter):
    """Return the answer with each bit 8 cleared."""
    if letter:
        write(controller, letter)
    bench.run(0.1)
    return bytes(byte & 0x7F for byte in controller.serial.read()).decode().rstrip("\r")


def test_a_bracket_at_another_baud_rate_that_is_cut_off_is_none(bench):
    """Breaking in: a `(` that a broken wire cuts off is no `(`, and the next character is read as usual."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.serial.host.baudrate = 1200
    if2.serial.write(b"(")
    bench.run(0.0002)  # a quarter of the start bit
    if2.serial.to_device.cut()
    bench.run(0.1)
    if2.serial.to_device.mend()
    if2.serial.host.baudrate = 9600
    assert status(bench, if2, "E") == "["
    if2.serial.host.baudrate = 1200
    if2.serial.write(b"(")
    bench.run(0.005)  # in its sixth bit
    if2.serial.to_device.cut()
    bench.run(0.1)
    if2.serial.to_device.mend()
    if2.serial.host.baudrate = 9600
    write(if2, "")
    assert status(bench, if2, "E") == "["


def test_the_format_set_after_breaking_in_starts_the_stored_sequence(bench):
    """Changing: the IF2 starts "the previously-stored sequence as soon as the "U" or "V" command has been received"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if2) == (100, 50, 0)
    if2.serial.host.baudrate = 2400
    if2.serial.write(b"(")
    bench.run(0.1)
    write(if2, "V61", end="\n")
    bench.run(1.0)
    assert (positions(if2), ask(bench, if2, "E", end="\n")[-3:]) == ((200, 100, 0), b"[\r\n")


def test_no_breaking_in_while_a_move_is_in_progress(bench):
    """Lockout: while a stored sequence moves an axis, `(` is ignored."""
    if2 = stored(bench, ":X1000@400:$")
    power_up(bench, if2, dsr=False)
    bench.run(0.5)
    for baudrate in (1200, 9600):
        if2.serial.host.baudrate = baudrate
        command(bench, if2, "(")
    bench.run(3.0)
    assert if2.serial.read() == b"" and positions(if2)[0] >= 1000
    assert send(bench, if2, "(", seconds=0.1, end="") == b"U\r"


@pytest.mark.parametrize("baudrate", [1200, 9600])
def test_no_breaking_in_while_dsr_is_low(bench, baudrate):
    """Changing: "In this case the DSR line must be held active, i.e. high"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.serial.host.dtr, if2.serial.host.baudrate = False, baudrate
    command(bench, if2, "(")
    if2.serial.host.dtr, if2.serial.host.baudrate = True, 9600
    bench.run(0.2)
    assert if2.serial.read() == b""
    write(if2, "")
    assert status(bench, if2, "E") == "["


def test_breaking_in_waits_for_no_terminator_and_forgets_what_was_typed_before(bench):
    """Breaking in: "(" acts at once, without a terminator; an incomplete message before it is dropped."""
    if1 = ready(bench)
    write(if1, "[")
    assert send(bench, if1, "X10(", seconds=0.1, end="") == b"U\r"
    send(bench, if1, "*", "U61", seconds=1.5)
    assert (status(bench, if1, "E"), number(bench, if1, "F")) == ("C", 0)


# Breaking in


@pytest.mark.parametrize("erase", ["*", "**", "*\r", "*\r\n"])
def test_breaking_into_a_locked_interface(bench, erase):
    """Breaking: "issue the open bracket "(" followed by the erase command", "The response ... is "U<CR>""; R28."""
    if2 = stored(bench, ":X100@400:Y50:$")
    bench.run(3.0)
    before = positions(if2)
    power_up(bench, if2, dsr=True)
    assert send(bench, if2, "(", seconds=0.1, end="") == b"U\r"
    if2.serial.write(erase.encode())
    bench.run(0.1)
    assert if2.serial.read() in ((b"U\r", b"U\rU\r") if erase == "**" else (b"U\r",))
    command(bench, if2, "U61", seconds=3.0)
    assert positions(if2) == before
    assert (status(bench, if2, "E"), number(bench, if2, "F")) == ("C", 0)
    command(bench, if2, ":$", "X$", seconds=1.0)
    assert positions(if2) == before  # the sequence and the distance are erased
    command(bench, if2, "Z5$", seconds=1.0)
    assert positions(if2)[2] == before[2] + 5


def test_what_has_been_erased_does_not_come_back(bench):
    """Breaking: "erase stored sequence statements in the RAM": also if the power goes at once."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=True)
    if2.serial.write(b"(")
    bench.run(0.1)
    if2.serial.write(b"*")
    bench.run(0.1)
    if2.power(False)
    if2.serial.read()
    power_up(bench, if2, dsr=False)
    if2.pins["input1"].drive(True)
    bench.run(3.0)
    assert positions(if2) == (0, 0, 0)
    assert send(bench, if2, "(", seconds=0.1, end="") == b"U\r"  # as new from the factory, it waits for this `(`


def test_installing_a_sequence_as_sample_6_does(bench):
    """Sample 6: `(`, the answer, `*`, the answer, `V61`, E until not E, the sequence (R30), `[`; CR LF after each."""
    if2 = bench.add("if2", line="2400 8N2")
    bench.run(1.5)
    send(bench, if2, "(", end="")
    assert send(bench, if2, "*", end="\r\n") == b"U\r"
    assert send(bench, if2, "V61", "E", seconds=1.5, end="\r\n") == b"C\r\n"
    if2.serial.write(b":R12345:H1:X1000@1000S1:X-S2:YS3:Y-S4:ZS5:Z-R5:")
    command(bench, if2, "XYZR4:X-Y-ZR3:X-Y-ZR2:X-YZR1:=0,1:$", "[", seconds=1.0, end="\r\n")
    if2.power(False)
    power_up(bench, if2, dsr=False)
    on = edges(if2.pins["output1"])
    if2.pins["input1"].drive(True)
    bench.run(25.0)
    # each of the 10 moves of 1000 steps at 1000/s takes 60 + 922 + 60 = 1042 ms
    ons = [at_ns for at_ns, level in on if level]
    assert len(ons) == 3
    assert 10_420 * MS <= ons[1] - ons[0] <= 10_423 * MS
    assert ask(bench, if2, "E", end="\r\n") == b"[\r\n"


# Power cuts


@pytest.mark.parametrize("cut_s", [0.0, 0.0001, 0.5, 0.9999, 1.0, 1.0001, 1.06, 1.1, 1.3105, 1.5, 1.56, 2.0])
def test_a_power_cut_at_any_moment_of_the_start_and_the_sequence(bench, cut_s):
    """Battery backup: "a stand-alone pre-programmed controller": after each power cut the sequence starts anew."""
    if2 = stored(bench, ":S1:X100@400BP2,25:Y50:R1:$")
    bench.run(2.0)
    if2.serial.host.dtr = False
    if2.power(True)
    bench.run(cut_s)
    if2.power(False)
    bench.run(0.1)
    cut_at = positions(if2)
    bench.run(10.0)
    assert positions(if2) == cut_at
    assert not any(if2.pins[name].level for name in ("output1", "output2", "led"))
    if2.power(True)
    bench.run(5.0)
    assert tuple(b - a for a, b in zip(cut_at, positions(if2), strict=True)) == (100, 50, 0)


def test_a_power_cut_in_the_middle_of_a_message_and_of_an_answer(bench):
    """After power-up neither the message nor the rest of the answer is left."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.serial.write(b"KFIOENKFIOEN")
    bench.run(0.005)
    if2.power(False)
    bench.run(0.1)
    if2.serial.read()
    power_up(bench, if2, dsr=False)
    assert (if2.serial.read(), [status(bench, if2, letter) for letter in "EF"]) == (b"", ["[", "32"])


def test_a_locked_interface_without_a_sequence_starts_nothing(bench):
    """Battery backup: data without a sequence are stored too, and nothing is started at power-up."""
    if2 = ready(bench, model="if2")
    command(bench, if2, "X60@200$", "[", seconds=1.0)
    if2.power(False)
    power_up(bench, if2, dsr=False)
    bench.run(2.0)
    assert (positions(if2), status(bench, if2, "E")) == ((60, 0, 0), "[")
    write(if2, "]", "Y$")
    until_idle(bench, if2)
    assert positions(if2) == (60, 60, 0)
    assert since_start(if2.axes["Y"]) == constant(200, 60)


def test_a_sequence_with_a_hand_over_at_power_up(bench):
    """Intervention, while locked: the prompt `%` is sent, but a `%` of the host is ignored like other commands."""
    if2 = stored(bench, ":X10@400:%:Y10:$")
    bench.run(1.0)
    power_up(bench, if2, dsr=False)
    bench.run(1.5)
    assert if2.serial.read() == b"%\r"
    command(bench, if2, "%", seconds=0.5)
    assert positions(if2)[1] == 0
    command(bench, if2, "]", "%", seconds=0.5)
    assert positions(if2)[1] == 10


@pytest.mark.parametrize("name", ["estop", "x_fault", "y_fault"])
def test_a_fault_there_at_power_up_keeps_the_stored_sequence_from_moving(bench, name):
    """Running: "power must be temporarily removed in order to reset the system"; without the fault it then starts."""
    if2 = stored(bench, ":X100@400:Y50:$")
    bench.run(2.0)
    before = positions(if2)
    if2.pins[name].drive(not if2.pins[name].level)
    power_up(bench, if2, dsr=False)
    bench.run(3.0)
    assert positions(if2) == before and if2.pins["led"].level
    assert status_word(bench, if2) == (32 if name == "estop" else 16)
    if2.pins[name].release()
    bench.run(3.0)
    assert positions(if2) == before
    if2.power(False)
    power_up(bench, if2, dsr=False)
    bench.run(3.0)
    assert tuple(b - a for a, b in zip(before, positions(if2), strict=True)) == (100, 50, 0)


def test_an_emergency_stop_can_be_read_away_once_it_is_unlocked(bench):
    """Running: the power must be removed only "when the interface is operating in the battery-backup mode"."""
    if2 = stored(bench)
    power_up(bench, if2, dsr=False)
    if2.pins["estop"].drive(False)
    bench.run(0.1)
    if2.pins["estop"].release()
    assert [status_word(bench, if2) for _ in range(2)] == [32, 32]
    command(bench, if2, "]", seconds=0.1)
    assert [status_word(bench, if2) for _ in range(2)] == [32, 0]
    write(if2, "X30@400$")
    until_idle(bench, if2)
    assert positions(if2) == (30, 0, 0)
