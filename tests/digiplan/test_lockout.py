"""Communication lockout commands."""

import pytest

from .talking import ask, command, number, play, positions, ready, scripts, send, status, status_word, until_idle, write


def test_a_locked_interface_receives_no_further_instructions(bench, if1):
    """Lockout: "will prevent the interface from receiving any further instructions until the unlock command"."""
    write(if1, "[")
    for text in ("X100$", "S1$", "@200", "B-20", "D25", "<8", ":Y10:$", "P2,50$", "%", "#", "["):
        write(if1, text)
    bench.run(2.0)
    assert positions(if1) == (0, 0, 0)
    assert not if1.pins["output1"].level
    write(if1, "]", "X100$")
    until_idle(bench, if1)
    assert (positions(if1), number(bench, if1, "F")) == ((100, 0, 0), 0)


@scripts(
    {
        "Lockout: parameters are instructions too": "X50$; idle; [; X70@100$; ]; X$; 0.3 s; at 100 0 0",
        'Lockout: "although it will respond to status request commands"':
        "X7$; idle; [; K: 0; F: 32; I: 200; O: 0; E: [; N: 7; Q: 0",
        'Busy status: "[<CR>" if it is in the battery backup mode"; R31: an IF1 has it too':
        "[; E: [; F: 32; ]; E: C; F: 0",
        'Battery backup: "Error checking becomes operative again as soon as the unlock command has been received"':
        "[; !; ]; !; 0.1 s; K: 128; F: 8",
        'Motion status: "any communication fault bits are only cleared when the "F" command is sent"':
        "!; [; 0.1 s; F: 40; F: 32",
        "Lockout: it concerns RS232 communication": "X1000@400$; 0.5 s; [; 0.1 s; #; K: 3; 3 s; at 1000 0 0",
        "Battery backup: `]` without a lock does nothing": "]; 0.1 s; K: 0; E: C",
        "Lockout: a second `[` is ignored, so one `]` unlocks": "[; [; ]; E: C",
        "Lockout and intervention: `%` is an instruction too; it works again after unlocking":
        ":%:X10@400:$; 0.1 s; receives %<CR>; [; %; 0.5 s; at 0 0 0; ]; %; 0.5 s; at 10 0 0",
        "Lockout: status requests are answered; a limit is reported as before":
        "X4000@400$; [; 1 s; limit_plus low; 0.5 s; K: 64; E: [",
        "R9 and lockout: first the two moves, then the lock": "X400@400$; X200$; [; 0.5 s; 2 s; at 600 0 0; E: [",
    }
)  # fmt: skip
def test_locked_and_unlocked(bench, if1, script):
    play(bench, if1, script)


def test_spurious_data_raises_no_fault_while_locked(bench, if1):
    """Battery backup: "No communication error checking is carried out whilst the interface is locked up"."""
    command(bench, if1, "[", seconds=0.1)
    for text in ("!!?", "@99999", "X65536/Y1$", ":::", ")*", "K K"):
        write(if1, text)
    if1.serial.host.parity = "E"  # this makes each character a format error
    write(if1, "X1000$")
    if1.serial.host.parity = "N"
    if1.serial.host.baudrate = 300
    command(bench, if1, "UUUUUU", seconds=1.0)
    if1.serial.host.baudrate = 9600
    send(bench, if1, "", seconds=0.1)
    assert (status_word(bench, if1), number(bench, if1, "F")) == (0, 32)
    command(bench, if1, "]", seconds=0.1)
    assert (status_word(bench, if1), number(bench, if1, "F")) == (0, 0)


def test_a_flood_raises_no_fault_while_locked(bench, if1):
    """Battery backup: without error checking, a flood of characters is dropped without a fault."""
    command(bench, if1, "[", seconds=0.1)
    if1.serial.write(b"X" * 500)
    bench.run(2.0)
    write(if1, "")
    assert (status_word(bench, if1), number(bench, if1, "F")) == (0, 32)


def test_a_sequence_goes_on_when_the_interface_is_locked(bench, if1):
    """Lockout: "useful if the controller must be disconnected or switched off"."""
    command(bench, if1, ":X100@400:Y:X-:Y-:=0,1:$", "[", seconds=0.1)
    command(bench, if1, "#", seconds=10.55)
    assert status(bench, if1, "O") in ("2", "3")
    assert status(bench, if1, "E") == "["
    command(bench, if1, "]", "#", seconds=0.1)
    assert status(bench, if1, "E") == "C"


def test_the_unlock_command_must_come_in_the_same_format(bench, if1):
    """Lockout: "must be sent at exactly the same baud rate, number of bits etc. as the lock command"."""
    command(bench, if1, "[", seconds=0.1)
    host = if1.serial.host
    # With odd parity, 8 bits or 7, `]` and <CR> have a 0 where the first stop bit is expected.
    for baudrate, parity, bytesize in ((1200, "N", 8), (4800, "N", 8), (9600, "O", 8), (9600, "N", 7)):
        host.baudrate, host.parity, host.bytesize = baudrate, parity, bytesize
        command(bench, if1, "]", seconds=0.3)
    host.baudrate, host.parity, host.bytesize = 9600, "N", 8
    command(bench, if1, "", seconds=0.1)
    assert status(bench, if1, "E") == "["
    write(if1, "]")
    assert status(bench, if1, "E") == "C"


@pytest.mark.parametrize(("bytesize", "parity"), [(7, "E"), (7, "M"), (8, "O"), (8, "S")])
def test_another_number_of_bits_or_another_parity_does_not_unlock(bench, if1, bytesize, parity):
    """Lockout: `]` and <CR> from a host at 7E have bit 8 set, which was clear in the lock command.

    At 8O and 8S the parity bit is a framing error.  7O, 8E and 8M look on the wire like 8N: `]` and <CR> have an odd
    number of ones.
    """
    command(bench, if1, "[", seconds=0.1)
    host = if1.serial.host
    host.bytesize, host.parity = bytesize, parity
    command(bench, if1, "]", seconds=0.1)
    host.bytesize, host.parity = 8, "N"
    write(if1, "")
    assert status(bench, if1, "E") == "["


def test_a_host_whose_parity_bit_lies_in_bit_8_unlocks_as_it_has_locked(bench, if1):
    """Lockout: "exactly the same ... as the lock command" counts, even if the data format is different."""
    host = if1.serial.host
    host.bytesize, host.parity = 7, "E"
    command(bench, if1, "[", seconds=0.1)
    host.bytesize, host.parity = 8, "N"
    write(if1, "]")
    assert status(bench, if1, "E") == "["
    host.bytesize, host.parity = 7, "E"
    command(bench, if1, "]", seconds=0.1)
    host.bytesize, host.parity = 8, "N"
    assert status(bench, if1, "E") == "C"


@pytest.mark.parametrize("text", ["]$", "]]", "X]", "]X10$", "[]"])
def test_only_the_unlock_command_alone_unlocks(bench, if1, text):
    """Lockout: "]" <CR>" must be a message of its own."""
    command(bench, if1, "[", text, seconds=0.1)
    assert (status(bench, if1, "E"), positions(if1)) == ("[", (0, 0, 0))


@pytest.mark.parametrize("text", ["[$", "X10[", "[X10$", "[[", "]]"])
def test_the_lock_command_stands_alone(bench, if1, text):
    """Lockout: "[ <CR>" must be a message of its own; otherwise it is a data fault (R7)."""
    command(bench, if1, text)
    assert (number(bench, if1, "F"), positions(if1)) == (8, (0, 0, 0))


def test_a_locked_interface_echoes_as_before(bench):
    """Echo-back: a locked interface still echoes, but executes nothing."""
    if1 = ready(bench, "U62")
    assert (ask(bench, if1, "["), ask(bench, if1, "E"), ask(bench, if1, "]")) == (b"[\r", b"E\r[\r", b"]\r")
    assert ask(bench, if1, "E") == b"E\rC\r"


def test_lock_and_unlock_in_the_v_format(bench):
    if1 = ready(bench, "V61")
    write(if1, "[", end="\n")
    assert ask(bench, if1, "E", end="\n") == b"[\r\n"
    write(if1, "]", end="\r\n")
    assert ask(bench, if1, "E", end="\n") == b"C\r\n"


def test_an_emergency_stop_while_locked_needs_the_power_off(bench, if1):
    """Battery backup: "power must be temporarily removed in order to reset the system"."""
    command(bench, if1, ":X100@400:=0,1:$", "[", seconds=1.0)
    if1.pins["estop"].drive(False)
    bench.run(0.5)
    if1.pins["estop"].release()
    for _ in range(3):
        assert status_word(bench, if1) == 32
    stands = positions(if1)
    bench.run(5.0)
    assert positions(if1) == stands
    assert if1.pins["led"].level


def test_a_message_in_two_parts_around_the_lock(bench, if1):
    """Lockout: `X100[` is a data fault, so the interface is not locked (R7)."""
    if1.serial.write(b"X100")
    bench.run(0.1)
    command(bench, if1, "[", "X60$", seconds=0.5)
    assert (positions(if1), number(bench, if1, "F")) == ((60, 0, 0), 8)
