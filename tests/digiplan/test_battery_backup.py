"""Using the battery backup: the IF2 keeps a locked sequence and its data without power."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS, S
from axistwin.sim.frames import UartFormat

from ..scripts import scripts
from .talking import (
    arrivals,
    ask,
    constant,
    each_character,
    edges,
    host_format,
    play,
    positions,
    pulse_times_of,
    ramped,
    ready,
    send,
    since_start,
    status,
)

STORED = ":H1:X100@400:Y50:$"


def stored(bench: Bench, sequence: str = STORED, form: str = "U61", **options: object) -> Controller:
    """Return an IF2 with a locked sequence and its power off."""
    if2 = ready(bench, form, "if2", **options)
    play(bench, if2, f"sends {sequence}<CR>; 0.1 s; sends [<CR>; 0.2 s; power off")
    return if2


# Running the stored sequence


@scripts({
    'Running: "A switch input may be used to start the stored sequence at power-up"':
    "at 0 0 0; power up; 2 s; at 0 0 0; O: 1; E: [; input1 high; 1 s; at 100 50 0; O: 3",
    'Control lines: "will therefore not transmit data until DSR and CTS are both set"; R4: held, not lost':
    "host DTR off; power on; 1.05 s; E; 0.2 s; host DTR on; 0.1 s; receives [<CR>",
    "A switch that is already on or off: power on and off twice is no different from once":
    "power off; host DTR off; power on; 1.05 s; input1 high; 0.1 s; power on; 1 s; at 100 50 0",
    'Running: "No communication error checking is carried out whilst the interface is locked up"':
    "power up; host 300; UUU; 0.5 s; host 9600; sends <CR>nonsense<CR>; 0.1 s; K: 0; F: 32; "
    "sends ]<CR>nonsense<CR>; 0.1 s; K: 128; F: 8",
    'Changing: "it is first necessary to unlock the interface"; the stored sequence still waits for input 1':
    "power up; ]; E: E; #; E: C; Z30$; idle; at 0 0 30; input1 high; :$; idle; at 100 50 30",
    'Changing: unlock, "the cancel code "# <CR>" followed by the new sequence data"':
    "power up; ]; #; :H1:Z77@400:$; [; 0.2 s; E: [; power up; input1 high; 1 s; at 0 0 77",
    "Storing: an unlocked sequence is lost without power":
    "power up; ]; 0.1 s; power up; input1 high; 2 s; at 0 0 0; E; 0.2 s; ( -> U<CR>",
    'Running: the power must be removed only "when the interface is operating in the battery-backup mode"':
    "power up; estop low; 0.1 s; estop released; K: 32; K: 32; ]; 0.1 s; K: 32; K: 0; X30@400$; idle; at 30 0 0",
    'Changing: "The baud rate and data format can be reprogrammed even if the interface is in the locked-up mode"':
    "power up with DSR; host 300; sends (; 0.3 s; receives U<CR>; sends V61<LF>; 2 s; "
    "power up; sends E<LF>; 0.5 s; receives [<CR><LF>",
    'Initialisation: the baud rate is detected once: a second `(` at another one is not answered with "U"':
    "power up with DSR; ( -> U<CR>; host 4800; sends (; 0.1 s; host 9600; ( -> U<CR>",
    "Breaking in: a `(` that a broken wire cuts off is no `(`, and the next character is read as usual":
    "power up; host 1200; sends (; 0.0002 s; cut; 0.1 s; mend; host 9600; E: [; "  # a quarter of the start bit
    "host 1200; sends (; 0.005 s; cut; 0.1 s; mend; host 9600; sends <CR>; E: [",  # in its sixth bit
    'Changing: "the previously-stored sequence as soon as the "U" or "V" command has been received"':
    "power up; input1 high; 1 s; at 100 50 0; host 2400; ( -> U<CR>; sends V61<LF>; 1 s; "
    "at 200 100 0; E<LF> -> [<CR><LF>",
    'Breaking: "erase stored sequence statements in the RAM": also if the power goes at once':
    "power up with DSR; ( -> U<CR>; * -> U<CR>; "
    "power up; input1 high; 3 s; at 0 0 0; ( -> U<CR>",  # as new, it waits for this `(`
    "After power-up neither the message that the power cut off nor the rest of an answer is left":
    "power up; sends KFIOENKFIOEN; 0.005 s; power up; E: [; F: 32",
})  # fmt: skip
def test_a_stored_sequence_that_waits_for_input_1(bench, script):
    play(bench, stored(bench), script)


@scripts({
    "Battery backup: data without a sequence are stored too, and nothing is started at power-up":
    "X60@200$; [; 1 s; power up; 2 s; at 60 0 0; E: [; ]; Y$; idle; at 60 60 0",
    "Lockout: a lock command held behind a move is unlocked in the format in which it was received":
    "X40$; Y20$; [; 1 s; E: [; power up; E: [; ]; E: C",
    "Intervention, while locked: the prompt `%` is sent, but a `%` of the host is ignored like other commands":
    ":X10@400:%:Y10:$; 0.1 s; receives %<CR>; [; 0.2 s; power up; 1.5 s; receives %<CR>; %; 0.5 s; Y at 0; "
    "]; %; 0.5 s; Y at 10",
    "Lockout: while a stored sequence moves an axis, `(` is ignored":
    ":X1000@400:$; 3 s; [; 0.1 s; power up; 0.5 s; host 1200; (; 0.2 s; host 9600; (; 0.2 s; 3 s; at 2000 0 0; "
    "( -> U<CR>",
    'Running: "If an emergency stop input is received ... power must be temporarily removed in order to reset"':
    ":H1:X100@400:=0,2:$; 0.1 s; [; 0.1 s; power up; input1 high; 1 s; estop low; 0.5 s; estop released; "
    "X between 360 400; mark; K: 32; K: 32; K: 32; 5 s; moved 0 0 0; led is high; "
    "power up; 1 s; X between 660 820; led is low",
})  # fmt: skip
def test_what_is_locked_before_power_off(bench, script):
    play(bench, ready(bench, model="if2"), script)


def test_a_sequence_that_begins_without_an_input_runs_at_once(bench):
    """Storing: ":H1:" "prevents the interface from executing the sequence at power-up"; without it, it runs."""
    if2 = ready(bench, model="if2")
    play(bench, if2, ":X100@400:Y50:$; 3 s; [; 0.1 s; at 100 50 0; power off; 3 s; host DTR off")
    on_ns = bench.now
    play(bench, if2, "power on; 3 s; at 200 100 0")
    # after the self-test of about 1 s; the manual does not say whether a ramp is calculated first
    first_ns = int(if2.axes["X"].pulse_times(on_ns)[0])
    assert 1 * S <= first_ns - on_ns <= 2 * S + 10 * MS


@pytest.mark.parametrize(("model", "lock"), [("if1", ""), ("if2", ""), ("if1", "[; ")])
def test_without_the_lock_command_or_the_battery_the_sequence_is_lost(bench, model, lock):
    """Storing: "must then be sent before power-down, otherwise the sequence data will be lost".

    R31: on an IF1 the lock command "works, but nothing survives power off": the IF1 has no battery.
    """
    lost = "power up; input1 high; 5 s; at 0 0 0; ( -> U<CR>; U61; 1.5 s; F: 0; E: C"
    play(bench, ready(bench, model=model), f"{STORED}; {lock}0.1 s; {lost}")


def test_the_speed_data_and_the_ramp_are_kept_too(bench):
    """Battery backup: "enables any data or sequence sent to the interface to be stored"."""
    if2 = ready(bench, model="if2")
    data = ">2 <6 ^20; 1.2 s; B-30; P1,7$; X700@3000$; :H1:XB:P2:$; 3 s; [; 0.1 s; at 700 0 0"
    play(bench, if2, f"{data}; power off; 1000000 s; power up")
    pulse = edges(if2.pins["output2"])
    play(bench, if2, "input1 high; 5 s; X moves 700 730 -30")
    assert pulse[1][0] - pulse[0][0] == 70 * MS
    # range 2: start/stop 600, increment 200, every 200/20000 s = 10 ms
    assert since_start(if2.axes["X"], -2)[:730] == pulse_times_of(ramped(730, 600, 3000, 200, 20_000))
    assert since_start(if2.axes["X"]) == constant(600, 30)


def test_the_inter_character_delay_is_kept(bench):
    """Battery backup: "any data" is stored, the inter-character delay too."""
    if2 = ready(bench, model="if2")
    play(bench, if2, "D10; [; 0.5 s; power up")
    received = arrivals(bench, if2)
    play(bench, if2, "F; 1 s; receives 32<CR>")
    assert received[1][0] - received[0][0] >= 100 * MS


def test_the_baud_rate_and_the_format_are_kept(bench):
    """Running, condition 2: "the same baud rate and data format as defined by the "U" and "V" commands"."""
    form = "detect; sends V22<CR><LF>; 0.2 s; host 7N2; 1.2 s; [<LF> -> [<LF>"  # 7 bits, 2 stop bits, no parity, echo
    kept = "power up; sends E<LF>; 0.5 s; receives E<LF>[<CR><LF>"
    play(bench, bench.add("if2", line="1200 8N2"), f"{form}; {kept}")


def test_the_positions_of_the_machine_stay_when_the_power_goes(bench):
    """Ruling 6: "Positions of axes are the bench's and survive a power cycle"; the sequence begins anew."""
    if2 = stored(bench)
    play(bench, if2, "power up; input1 high; 0.15 s; X between 1 99")
    x = if2.axes["X"].position
    play(bench, if2, f"power off; 5 s; at {x} 0 0; power up; 1 s; at {x + 100} 50 0")


def test_the_outputs_are_off_when_the_power_comes_back(bench):
    """Default values: "Outputs 1-5 - Off": levels of outputs are not among the stored data."""
    if2 = stored(bench, ":S135:H1:R1:$")
    levels = [edges(if2.pins[f"output{n}"]) for n in (1, 2)]
    play(bench, if2, "0.1 s; outputs 00000; power up; 1 s; outputs 10101")
    assert [len(seen) for seen in levels] == [1, 0]


# What can be said to a locked interface


@pytest.mark.parametrize(("wiring", "power_up"), [("3-wire", "power up with DSR"), ("5-wire", "power up")])
def test_status_requests_only(bench, wiring, power_up):
    """Running: "restricted to status request codes only, and any other command instructions will be ignored".

    Running, condition 1: "In a 3-wire system this can be achieved by linking DSR to CTS and RTS": DSR then counts as
    low at power-up, whatever the levels of the host's lines are.
    """
    others = "X100$; #; :X10:$; @200; S1$; *; U61; 1 s; at 0 0 0; O: 1; F: 32; input1 high; 1 s; at 100 50 0"
    play(bench, stored(bench, wiring=wiring), f"{power_up}; K: 0; F: 32; I: 200; O: 1; E: [; N: 0; {others}")


# DSR high: a new data format


@pytest.mark.parametrize("wiring", ["5-wire", "3-wire DSR-DTR"])
def test_with_dsr_high_the_format_is_set_anew_and_starts_the_sequence(bench, wiring):
    """Changing: "DSR line must be held active"; "start to execute ... as soon as the "U" or "V" command".

    It is still locked; to the letter, `]` comes "at same baud rate and data format as the previous lock command".
    """
    play(
        bench,
        ready(bench, model="if2", wiring=wiring, unlock="lock format"),
        ":X100@400:Y50:$; 3 s; [; 0.1 s; power up with DSR; 5 s; at 100 50 0; E; 0.2 s; "
        "host 1200; ( -> U<CR>; at 100 50 0; sends V62<CR><LF>; 3 s; at 200 100 0; "
        "sends E<LF>; 0.5 s; receives E<LF>[<CR><LF>; sends ]<LF>; 0.5 s; receives ]<LF>; "
        "sends E<LF>; 0.5 s; receives E<LF>[<CR><LF>",
    )


@pytest.mark.parametrize("options", [{}, {"unlock": "any format"}])
def test_the_unlock_command_in_the_new_format(bench, options):
    """Lockout: "However, it is possible to re-initialise the interface with a different data format"."""
    play(
        bench,
        stored(bench, **options),
        "power up with DSR; host 1200; ( -> U<CR>; sends V61<CR><LF>; 1 s; sends ]<LF>; 0.5 s; "
        "sends E<LF>; 0.5 s; receives E<CR><LF>",  # the stored sequence waits for input 1
    )


@pytest.mark.parametrize("baudrate", [110, 300, 600, 1200, 2400, 4800, 9600])
def test_the_bracket_breaks_in_without_a_power_cycle_while_dsr_is_held(bench, baudrate):
    """Breaking in: "issue the open bracket "(" followed by the erase command", while the sequence waits for input 1."""
    play(
        bench,
        stored(bench),
        f"power up; E: [; host {baudrate}; sends (; 0.5 s; receives U<CR>; sends *; 0.5 s; receives U<CR>; U61; 3 s; "
        "input1 high; E; 1 s; receives C<CR>; at 0 0 0",  # the sequence is erased
    )


@pytest.mark.parametrize("lock", [2400, 4800, 9600])
def test_nothing_else_that_a_host_says_is_taken_for_a_bracket_at_another_baud_rate(bench, lock):
    """Lockout: "it will respond to status request commands"; at another baud rate only `(` is accepted."""
    if2 = bench.add("if2")
    play(bench, if2, f"host {lock}; 1.1 s; ( -> U<CR>; U31; 1.2 s; [; 0.1 s")
    for byte in (*range(1, ord("(")), *range(ord("(") + 1, 128)):
        if2.serial.write(bytes([byte]))
        bench.run(0.02)
    send(bench, if2, "", seconds=0.1)
    assert status(bench, if2, "E") == "["


@pytest.mark.parametrize("form", ["U11", "U13", "U14", "U63", "U64", "U33", "U71"])
def test_the_bracket_breaks_in_whatever_the_format_of_the_lock_command(bench, form):
    """Breaking in: the host need not know the format of the lock command; it may have 8 bits and no parity."""
    if2 = stored(bench, form=form)
    play(bench, if2, "power up")
    assert ask(bench, if2, "E")[:1] == (b"\xdb" if form == "U71" else b"[")
    for way in (UartFormat(9600, 8, "N", 2), UartFormat(2400, 8, "N", 1), UartFormat(1200, 7, "E", 1)):
        if2.serial.host.format = way
        answer = ask(bench, if2, "(", 0.1, end="")
        assert bytes(byte & 0x7F for byte in answer) == b"U\r", way
        each_character(bench, if2, form + "\r", lambda n: bench.run(0.02))
        host_format(if2, form)
        bench.run(1.2)
        if2.serial.read()


def test_breaking_in_and_the_data_format_in_one_go(bench):
    """Changing: `(` and a data format end the waiting sequence before the same instant starts it again."""
    if2 = stored(bench, line="instant")
    play(bench, if2, "power up; (U61<CR> -> U<CR>")
    assert if2.busy
    play(bench, if2, "input1 high; 1 s; at 100 50 0")
    assert not if2.busy


@pytest.mark.parametrize("baudrate", [1200, 9600])
def test_no_breaking_in_while_dsr_is_low(bench, baudrate):
    """Changing: "In this case the DSR line must be held active, i.e. high"."""
    script = "power up; host DTR off; host {}; (; 0.2 s; host DTR on; host 9600; 0.2 s; sends <CR>; E: ["
    play(bench, stored(bench), script.format(baudrate))


def test_breaking_in_waits_for_no_terminator_and_forgets_what_was_typed_before(bench, if1):
    """Breaking in: "(" acts at once, without a terminator; an incomplete message before it is dropped."""
    play(bench, if1, "[; X10( -> U<CR>; *; U61; 1.5 s; receives U<CR>; E: C; F: 0")


def test_bit_8_of_what_was_typed_before_a_break_in_does_not_count_for_the_unlock_command(bench, if1):
    """Breaking in: an incomplete message before `(` is dropped; afterwards `]` has the format of `[`, and unlocks."""
    play(bench, if1, "[; sends <D8>; 0.1 s; ( -> U<CR>; U61; 0.1 s; ]; E: C")


# Breaking in


@pytest.mark.parametrize(("erase", "answer"), [
    ("*", "U<CR>"), ("**", "U<CR>U<CR>"), ("*<CR>", "U<CR>"), ("*<CR><LF>", "U<CR>")])  # fmt: skip
def test_breaking_into_a_locked_interface(bench, erase, answer):
    """Breaking: "issue the open bracket "(" followed by the erase command", "The response ... is "U<CR>""; R28."""
    play(
        bench,
        ready(bench, model="if2"),
        ":X100@400:Y50:$; 3 s; [; 0.1 s; power up with DSR; ( -> U<CR>; "
        f"sends {erase}; 0.1 s; receives {answer}; U61; 3 s; at 100 50 0; E: C; F: 0; "
        ":$; X$; 1 s; at 100 50 0; Z5$; 1 s; at 100 50 5",  # the sequence and the distance are erased
    )


def test_installing_a_sequence_as_sample_6_does(bench):
    """Sample 6: `(`, the answer, `*`, the answer, `V61`, E until not E, the sequence (R30), `[`; CR LF after each."""
    if2 = bench.add("if2", line="2400 8N2")
    begin = "1.5 s; ( -> U<CR>; *<CR><LF> -> U<CR>; sends V61<CR><LF>E<CR><LF>; 1.5 s; receives C<CR><LF>"
    sequence = ":R12345:H1:X1000@1000S1:X-S2:YS3:Y-S4:ZS5:Z-R5:XYZR4:X-Y-ZR3:X-Y-ZR2:X-YZR1:=0,1:$<CR><LF>"
    play(bench, if2, f"{begin}; sends {sequence}[<CR><LF>; 1 s; power up")
    on = edges(if2.pins["output1"])
    play(bench, if2, "input1 high; 25 s; E<CR><LF> -> [<CR><LF>")
    # each of the 10 moves of 1000 steps at 1000/s takes 60 + 922 + 60 = 1042 ms
    ons = [at_ns for at_ns, level in on if level]
    assert len(ons) == 3 and 10_420 * MS <= ons[1] - ons[0] <= 10_423 * MS


# Power cuts


@pytest.mark.parametrize("cut_s", [0.0, 0.0001, 0.5, 0.9999, 1.0, 1.0001, 1.06, 1.1, 1.3105, 1.5, 1.56, 2.0])
def test_a_power_cut_at_any_moment_of_the_start_and_the_sequence(bench, cut_s):
    """Battery backup: "a stand-alone pre-programmed controller": after each power cut the sequence starts anew."""
    if2 = stored(bench, ":S1:X100@400BP2,25:Y50:R1:$")
    play(bench, if2, f"2 s; host DTR off; power on; {cut_s:f} s; power off; 0.1 s")
    x, y, z = positions(if2)
    cut = f"10 s; at {x} {y} {z}; outputs 00000; led is low"
    play(bench, if2, f"{cut}; power on; 5 s; at {x + 100} {y + 50} {z}")


@pytest.mark.parametrize(("name", "status"), [("estop", 32), ("x_fault", 16), ("y_fault", 16)])
def test_a_fault_there_at_power_up_keeps_the_stored_sequence_from_moving(bench, name, status):
    """Running: "power must be temporarily removed in order to reset the system"; without the fault it then starts."""
    play(
        bench,
        ready(bench, model="if2"),
        f":X100@400:Y50:$; 3 s; [; 0.1 s; power off; {name} low; power up; 3 s; at 100 50 0; led is high; "
        f"K: {status}; {name} released; 3 s; at 100 50 0; power up; 3 s; at 200 100 0",
    )
