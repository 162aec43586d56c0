"""Communication lockout commands."""

from ..scripts import scripts
from .talking import ask, play, ready


@scripts({
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
    'Lockout: "will prevent the interface from receiving any further instructions until the unlock command"':
    "[; X100$; S1$; @200; B-20; D25; <8; :Y10:$; P2,50$; %; #; [; 2 s; at 0 0 0; outputs unchanged; ]; X100$; "
    "idle; X moves 100; X 100 pulses at 400; F: 0",
    'Lockout: "useful if the controller must be disconnected or switched off": a sequence continues':
    ":X100@400:Y:X-:Y-:=0,1:$; [; 0.1 s; #; 10.55 s; O: 2|3; E: [; ]; #; 0.1 s; E: C",
    # without error checking, a flood of characters is dropped without a fault
    'Battery backup: "No communication error checking is carried out whilst the interface is locked up"':
    "[; 0.1 s; !!?; @99999; X65536/Y1$; :::; )*; K K; host parity E; X1000$; host parity N; host baudrate 300; "
    "UUUUUU; 1 s; host baudrate 9600; sends <CR>; 0.1 s; K: 0; F: 32; ]; 0.1 s; K: 0; F: 0",
    'Battery backup: "power must be temporarily removed in order to reset the system" after an emergency stop':
    ":X100@400:=0,1:$; [; 1 s; estop low; 0.5 s; estop released; K: 32; K: 32; K: 32; X between 300 600; mark; "
    "5 s; moved 0 0 0; led is high",
    "Lockout: all but status requests is ignored, `#` too while a reply waits for the control lines":
    "X4000@400$; [; 0.1 s; host RTS off; E; 0.1 s; #; 0.5 s; moving; host RTS on; 0.1 s; receives [<CR>; moving",
    'Lockout: "at exactly the same baud rate, number of bits etc.": bit 8 of `]` must be that of `[`, 0':
    "[; sends <DD><CR>; E: [; ]; E: C",
    "Lockout: `X100[` is a data fault, so the interface is not locked (R7)":
    "sends X100; 0.1 s; [; X60$; 0.5 s; at 60 0 0; F: 8",
    'Lockout: "must be sent at exactly the same baud rate, number of bits etc. as the lock command". `]` and <CR> '
    "from a host at 7E have bit 8 set, which was clear in the lock command. At 7N, 8O and 8S they have a 0 where "
    "the first stop bit is expected. 7O, 8E and 8M look on the wire like 8N: `]` and <CR> have an odd number of "
    "ones":
    "[; 0.1 s; host baudrate {1200|4800|9600|9600|9600|9600|9600}; host bytesize {8|8|7|7|7|8|8}; host parity {N|"
    "N|N|E|M|O|S}; ]; 0.3 s; host baudrate 9600; host bytesize 8; host parity N; sends <CR>; 0.1 s; E: [; ]; E: C",
    'Lockout: "]" <CR>" must be a message of its own': "[; {]$|]]|X]|]X10$|[]}; 0.1 s; E: [; at 0 0 0",
    'Lockout: "[ <CR>" must be a message of its own; otherwise it is a data fault (R7)':
    "{[$|X10[|[X10$|[[|]]}; 0.2 s; F: 8; at 0 0 0",
})  # fmt: skip
def test_locked_and_unlocked(bench, if1, script):
    play(bench, if1, script)


def test_a_flood_raises_no_fault_while_locked(bench, if1):
    """Battery backup: without error checking, a flood of characters is dropped without a fault."""
    play(bench, if1, "[; 0.1 s; sends " + "X" * 500 + "; 2 s; sends <CR>; K: 0; F: 32")


def test_a_host_whose_parity_bit_lies_in_bit_8_unlocks_as_it_has_locked(bench, if1):
    """Lockout: "exactly the same ... as the lock command" counts, even if the data format is different."""
    as_locked, as_initialised = "host bytesize 7; host parity E", "host bytesize 8; host parity N"
    play(bench, if1, f"{as_locked}; [; 0.1 s; {as_initialised}; ]; E: [; {as_locked}; ]; 0.1 s; {as_initialised}; E: C")


def test_a_locked_interface_echoes_as_before(bench):
    """Echo-back: a locked interface still echoes, but executes nothing."""
    if1 = ready(bench, "U62")
    assert [ask(bench, if1, letter) for letter in "[E]E"] == [b"[\r", b"E\r[\r", b"]\r", b"E\rC\r"]


def test_lock_and_unlock_in_the_v_format(bench):
    play(bench, ready(bench, "V61"), "sends [<LF>E<LF>; 0.2 s; receives [<CR><LF>; sends ]<CR><LF>E<LF>; 0.2 s; "
         "receives C<CR><LF>")  # fmt: skip
