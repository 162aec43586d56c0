"""Section 2 of the base language, chapters 6 and 10: received characters, channels and replies."""

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .scenarios import points
from .scripts import play, scripts
from .talking import clear, load, ready, send

CHARACTER_S = 10 / 9600


@scripts({
    # Terminators
    "2: the terminators; a report ends with one CR and nothing else":
    [f"sends P=12 z=P Rz{terminator} -> 12" for terminator in (" ", '\r', '\n', '\x00')],
    "a command without its terminator is not obeyed yet":
    "sends a=1 Ra; 0.1 s; sends <CR> -> 1",
    "a quote that is not closed ends with the line":
    [f'sends PRINT("a b{end}; RBs -> 1' for end in ('\r', '\n', '\x00')],
    # Lists of array values
    "a list may have more characters than a command":
    f"aw[0] {' '.join(str(1000 + n) for n in range(102))}. Raw[0] Raw[101] -> 1000 1101",
    "A line end, or a word that is not a number, ends the list without effect; later commands are executed":
    "aw[0] 1 2\rRaw[0] RBs -> 0 1; ZS aw[0] 1 2 a=7 Ra Raw[0] RBs -> 7 0 1",
    "a list with too many values sets a flag and does no harm":
    f"ab[0] {' '.join('1' for n in range(300))}. ZS RU -> 127",
    # Long commands
    "there is no address 121":
    "SADDR121 RADDR RBs -> 0 1",
    "an address byte ends what had been begun":
    "sends SADDR1 G<81>RP RBs<SP> -> 0 1",
    # Line errors
    "a parity error sets bb":
    "line 9600 8N1; OCHN(RS2,0,E,9600,1,8,C); 0.1 s; host parity O; a=1; 0.1 s; host parity E; "
    "\rRa RBb RCHN0 RCHN1 RBf -> 0 1 8 0 0 in 0.2 s",
    "a break is a framing error and ends what had been begun":
    "line 9600 8N1; writes a=; break 0.01 s; 0.1 s; RBf RBs -> 1 0 in 0.1 s",
    "one damaged character spoils one command":
    "line 9600 8N1; OCHN(RS2,0,E,9600,1,8,C); 0.1 s; host parity E; flip 1; b=5 b=b+1 Rb -> 1 in 0.1 s",
    # Host mode records and direct binary commands
    "a record for others is passed over as a whole":
    "sends SADDR1 <82><FA><81><81><81><81><CR>RP <81>RBs<SP> -> 0",
    "A record without its CR sets Bs; it is dropped up to the next terminator, record or address":
    "sends MD <FA><00><00><00><00>XX a=1 Ra RBs Zs<SP> -> 1 1; "
    "sends <FA><00><00><00><00><FA><00><00><00><00><CR>RBs<SP> -> 1",
    # Speed and format
    "2: a report requested while another one is being sent follows it; no character is lost":
    "line 9600 8N1; RSP RP RP -> 24576/476 0 0 in 0.1 s",
    "ochn sets the format":
    "line 9600 8N1; OCHN(RS2,0,O,19200,2,7,C); 0.1 s; host baudrate 19200; host bytesize 7; host parity O; "
    "host stopbits 2; RP RBs -> 0 0 in 0.1 s",
    "what cannot be opened sets bs":
    [f"OCHN({parameters}) RBs -> 1"
     for parameters in (
         "RS2,1,N,9600,1,8,C", "RS3,0,N,9600,1,8,C", "RS2,2,N,9600,1,8,C", "RS2,0,X,9600,1,8,C",
         "RS2,0,N,9601,1,8,C", "RS2,0,N,9600,3,8,C", "RS2,0,N,9600,1,9,C", "RS2,0,N,9600,1,8,E", "RS2,0", "",
         "RS2,0,N,9600,1,8,C,x",
     )],
    "a closed channel neither hears nor speaks":
    "485 writes ; OCHN(RS4,1,N,9600,1,8,C) CCHN(RS2,0); RP; 485: OCHN(RS2,0,N,9600,1,8,C) RP -> 0 in 0.1 s; "
    "RBs -> 0",
    # Channel 1
    "channel 1 is closed at first":
    '485: RP; PRINT1("lost") RBs -> 0; 485 receives nothing',
    '6.2: an answer is sent "to the active channel"':
    'OCHN(RS4,1,N,9600,1,8,C); 485: RP RUA -> 0 1; receives nothing; PRINT1("one",#13); 485 receives one<CR>',
    "a channel sleeps by itself":
    "OCHN(RS4,1,N,9600,1,8,C) SLEEP1 ECHO1; 485: RP -> RP; RP -> 0; "
    "485: WAKE RP WAKE1 RP => WAKE RP WAKE1 RP<CR>0<CR>",
    # The running program
    "2: SILENT suppresses a program's output until TALK; reports that a host requests are still answered":
    'load PRINT("x") / Ra / END; SILENT RUN Ra -> 0 in 0.1 s; TALK RUN -> x0 in 0.1 s',
    # Direct binary commands: FE, FD, FC and four bytes, the most significant first
    "A direct binary command for P makes the next move absolute, as P= does":
    "sends A=65536*8 V=65536*8 D=5 <FE><00><00><00>dG<SP>; 0.1 s; sends RP RMODE<SP> -> 100 P",
    "A motor that is not addressed ignores addresses, terminators and letters in the data of such a command":
    "sends SADDR1 P=7 V=65536 A=65536 MV G<SP>; sends <82><FE><81> S RP <81>z=P Rz RBt RBs<SP> -> 7 1 0",
    "Base 4: A cannot be negative":
    "sends A=5 <FC><FF><FF><FF><FF>RA RBs<SP> -> 5 1",
    "A parity error in the third byte sets Bb; all five bytes still belong to the command":
    "line 9600 8N1; P=7 OCHN(RS2,0,E,9600,1,8,C); 0.1 s; host parity E; sends <FE><00>; 0.1 s; flip 1; "
    "sends <00>S z=P Rz RBb RBs<SP> -> 7 1 0 in 0.2 s",
    # OCHN's time-out
    "Later guides: the time-out is for command mode; in data mode no characters are dropped":
    "OCHN(RS4,1,N,9600,1,8,D,100); 485 writes ab; 0.5 s; a=LEN1 Ra RBs -> 2 0",
    'RCHN: the time-out is reported as "4 scan/syntax"; the incomplete command is dropped, Bs; Zs clears both':
    "OCHN(RS2,0,N,9600,1,8,C,100) ZS; RBs RCHN -> 0 0; a=; 2.0 s; RBs RCHN -> 1 4; Zs RBs RCHN -> 0 0",
    "Base 2: in data mode LEN counts the unread characters of channel 0, and LEN1 those of channel 1":
    "OCHN(RS4,1,N,9600,1,8,D); 485 writes xyz; 0.1 s; "
    "PRINT(LEN,#32,LEN1,#32,GETCHR1,#32,LEN1,#13) => 0 3 120 2<CR>",
    # Direct binary commands: FE, FD, FC and four bytes, the most significant first
    "The Class 4 language: a code byte and a 32-bit number, as in 10.1; a CR after it is an empty command":
    [f"sends {record}{after}z={name} Rz RBs<SP> -> {number} 0"
     for after in ("", "<CR>", "<SP>")
     for record, name, number in (
         # the manufacturer's examples, and data bytes that are neither addresses nor terminators
         ("<FE><00><00><00><64>", "P", 100), ("<FE><FF><FF><FF><FE>", "P", -2),
         ("<FD><00><00><27><10>", "V", 10000), ("<FD><FF><FF><D8><F0>", "V", -10000),
         ("<FC><00><00><00><08>", "A", 8), ("<FC><7F><FF><FF><FF>", "A", 2**31 - 1),
         ("<FE><80><81><0D><20>", "P", 0x80810D20 - 2**32),
     )],
    # OCHN's time-out
    "a time out that ends without power does nothing":
    "OCHN(RS2,0,N,9600,1,8,C,100); sends a=; 0.05 s; power off; 0.02 s; power on; sends RBs<SP> -> 0 in 0.2 s",
    # Commands
    "2: several commands may stand on one line, such as `z=V Rz`":
    "V=-5 z=V Rz a=3 Ra -> -5 3",
    "Empty commands mean nothing":
    "sends <SP><CR><LF><00><CR><CR><SP><SP>RBs<CR><LF> -> 0",
    "2: quotes keep the blanks in a command":
    'PRINT("a b  c",#13) => a b  c<CR>',
    "3: an unknown command is ignored and sets Bs; nothing is returned":
    "HELLO; RBs -> 1",
    "1.1: `aw[0] 0 100 500 700.` sets consecutive elements; the period ends the list":
    "aw[0] 0 100 -500 700. Raw[1] Raw[2] Raw[3] RBs -> 100 -500 700 0",
    "A list is cut short by a word that is too long":
    f"aw[0] 1 {'2' * 65} 3. RBc RBs Raw[0] -> 1 1 0",
    "2: the echo, before the answer, includes address bytes and terminators":
    "sends ECHO<SP>; sends <80>RP<CR><LF> => <80>RP<CR>0<CR><LF>; sends ECHO_OFF<SP> => ECHO_OFF<SP>; "
    "sends RP<CR> -> 0",
    "2: an address byte is 80h + address, and holds until the next one; 80h addresses all motors":
    "SADDR5 RADDR -> 5; sends <86>RP RP<SP>; sends RP<SP>; sends <85>RP RP<SP> -> 0 0; "
    "sends <86>RP <80>RP<SP> -> 0",
    "2: the echo includes the commands for others; a daisy chain needs it":
    "sends SADDR1 ECHO <82>RP<SP> => <82>RP<SP>",
    "2: a sleeping motor executes only WAKE, but it still echoes":
    "SLEEP a=1 Ra HELLO WAKE Ra RBs -> 0 0; sends ECHO SLEEP Ra WAKE<SP> => SLEEP Ra WAKE<SP>",
    "10.1: a record is 0xFA, four bytes, CR; its bytes are neither addresses nor terminators":
    "sends SADDR1 <81>MD <FA><82><0D><20><83><CR><FB><00><00><0D><00><CR>; sends RADDR RBs<SP> -> 1 0",
    "GETCHR of nothing is 0":
    "a=5 a=GETCHR Ra a=GETCHR1 Ra RBs -> 0 0 0",
    "The data of a direct binary command are not commands: 53h 20h are the command S":
    f"A=65536 V=65536 MV G; sends <FE><00><00><53><20>z=P Rz RBt RMODE<SP> -> {0x5320} 1 V",
    "A sleeping motor takes no direct binary command":
    "sends P=7 SLEEP <FE><00><00><00><64>WAKE z=P Rz<SP> -> 7",
    "As an address, a direct binary command drops an incomplete command and sets Bs":
    "sends a=1<FE><00><00><00><64>Ra z=P Rz RBs<SP> -> 0 100 1",
    "2: a command of more than 64 characters is dropped up to its terminator and sets Bc; later ones are executed":
    'PRINT("' + "x" * 55 + '") => ' + "x" * 55
    + '; PRINT("' + "x x" * 20 + '",#13) a=1 Ra RBc RCHN RCHN0 -> 1 1 1 1',
    "Addresses go up to 120":
    "sends SADDR1 <81>RBs<SP> -> 0; sends SADDR120 <F8>RBs<SP> -> 0",
    "Base 10: Bf. The host sends 8 data bits and a parity bit, which the motor reads as the stop bit":
    "line 9600 8N1; host parity S; a=1; 0.1 s; host parity N; sends <CR>Ra RBf RCHN RBs<CR> -> 0 1 2 0 in 0.2 s; "
    "Zf RBf RCHN -> 0 0 in 0.2 s",
    # 11: the first point is reached, two are left; 4F79h samples are 5 s
    "11: F9h or Q returns status, free places (of 32) and clock: 01h G pending; 80h running, with 24 bits of clock":
    f"sends MD <F9> => <F9><01><20><00><00>; {points((0, 0), (1024, 256))}Q => <F9><01><1E><00><00>; "
    f"{points((262_144, 65_536))}G; 5 s; sends <F9> => <F9><9E><00><4F><79>",
    # 10.2: one point is an underflow, 40h
    "11: 20h overflow, as a real motor answered `F9 20 00 00 00` to too many points; 04h a clock that goes back":
    f"MD; {points(*((n, 256 + n) for n in range(33)))}; Q => <F9><21><00><00><00>; "
    f"{points((0, 0))}Q => <F9><25><00><00><00>; MD Q => <F9><01><20><00><00>; {points((0, 0))}G; 4 samples; "
    "Q => <F9><40>*; MD Q => <F9><01><20><00><00>",
    "2: LEN1 counts and GETCHR1 reads the bytes of channel 1; a seventeenth byte sets Bc":
    f"OCHN(RS4,1,N,9600,1,8,D); 485 writes {''.join(map(chr, range(0x80, 0x90)))}; "
    "a=LEN1 Ra b=GETCHR1 Rb b=GETCHR1 Rb a=LEN1 Ra RBc -> 16 128 129 14 0; 485 writes <FA>RP; "
    "a=LEN1 Ra RBc RCHN1 RCHN0 -> 16 1 1 0",
    'Later guides: milliseconds "between issuing a command and detecting a delimiter"; else it is dropped, Bs':
    [f"OCHN(RS2,0,N,9600,1,8,C{timeout}); sends a=; {pause} s; sends 12<SP>; {reports}"
     for timeout, pause, reports in (
         (",100", 0.099, "Ra RBs -> 12 0"), (",100", 0.101, "RBs -> 1"), (",0", 10, "Ra RBs -> 12 0"),
         ("", 10, "Ra RBs -> 12 0"),
     )],
    "A space does not start the time-out, and each command has its own time-out":
    "OCHN(RS2,0,N,9600,1,8,C,100); sends a=1<SP>; 0.06 s; sends b=2<SP>; 0.06 s; sends <SP>; 0.06 s; sends c; "
    "0.06 s; sends =3<SP>; 0.06 s; Ra Rb Rc RBs -> 1 2 3 0; sends d; 0.06 s; sends =; 0.06 s; sends 4; 0.06 s; "
    "sends <SP>Rd RBs<SP> -> 0 1",
})  # fmt: skip
def test_serial_data(script):
    play(script)


# Addresses


def test_a_chain_is_addressed_from_power_up(bench):
    """2: a host sends SADDR1 to all, ECHO and SLEEP to each motor in turn, and at the end WAKE to all."""
    motors = [bench.add("smartmotor", line="instant") for _ in range(3)]
    chain = bench.chain(*motors)
    bench.run(0.3)
    for number in (1, 2, 3):
        send_to = bytes([0x80 + number])
        chain.write(b"\x80SADDR%d " % number + send_to + b"ECHO " + send_to + b"SLEEP ")
        bench.run(0.1)
    chain.write(b"\x80WAKE ")
    bench.run(0.1)
    chain.read()
    for number in (1, 2, 3):
        chain.write(b"%cRADDR " % (0x80 + number))
        bench.run(0.1)
        assert chain.read() == b"%cRADDR %d\r" % (0x80 + number, number)


# Host mode records and direct binary commands


FIRST, SECOND = b"\xfa\x00\x00\x00\x00\r\xfb\x00\x00\x00\x00\r", b"\xfa\x00\x00\x04\x00\r\xfb\x00\x00\x01\x00\r"
"""Points of host mode: 0 at 0, 1024 at 256."""


def test_the_answer_of_host_mode_wakes_no_motor_down_the_chain(bench):
    """2, 11: 80h and above are addresses, but not those in the answer of a motor further up: 9Eh would be motor 30."""
    motors = [clear(bench, bench.add("smartmotor", name=f"m{n}")) for n in (1, 2)]
    chain = bench.chain(*motors)
    chain.write(b"\x80SADDR1 ECHO ")
    bench.run(0.2)
    chain.write(b"\x81SLEEP \x80SADDR30 ECHO \x81WAKE \x81")
    bench.run(0.2)
    chain.read()
    chain.write(b"MD ")
    chain.write(FIRST + SECOND + b"\xfa\x00\x04\x00\x00\r\xfb\x00\x01\x00\x00\rG ")
    bench.run(1)
    chain.read()
    chain.write(b"\xf9")
    bench.run(0.1)
    assert chain.read()[:2] == b"\xf9\x9e"
    chain.write(b"a=7 ")  # still for motor 1 alone
    bench.run(0.1)
    chain.read()
    chain.write(b"\x9eRa ")
    bench.run(0.1)
    assert chain.read() == b"\x9eRa 0\r"


def test_a_motor_above_the_one_that_is_asked_takes_four_bytes_of_the_host_as_data(bench):
    """11: F9h and the four bytes after it are data for a motor that is not asked; four CR keep the next address."""
    motors = [clear(bench, bench.add("smartmotor", name=f"m{n}")) for n in (1, 2)]
    chain = bench.chain(*motors)
    for setup in (b"\x80SADDR1 ECHO ", b"\x81SLEEP \x80SADDR2 ECHO \x81WAKE "):
        chain.write(setup)
        bench.run(0.2)
    for filler, answer in ((b"", b""), (b"\r" * 4, b"0\r")):
        chain.write(b"\x82\xf9")
        bench.run(0.1)
        assert chain.read().endswith(b"\xf9\x00\x20\x00\x00")
        chain.write(filler + b"\x81RP ")
        bench.run(0.1)
        assert chain.read() == filler + b"\x81RP " + answer


# Speed and format


def arrivals_ms(bench: Bench, motor: Controller, text: str) -> list[float]:
    """Return the time of each character of the answer, in ms from the first character sent."""
    began, times = bench.now, list[float]()
    stop = motor.serial.subscribe_received(lambda byte, errors: times.append(round((bench.now - began) / 1e6, 3)))
    send(bench, motor, text, 0.1)
    stop()
    return times


def test_baud_takes_effect_at_once(bench):
    """2, BAUDn: at 38400 baud a character takes 0.2604 ms; three are received and two sent."""
    motor = clear(bench, bench.add("smartmotor"))
    assert send(bench, motor, "BAUD38400", 0.1) == b""
    motor.serial.host.baudrate = 38400
    assert arrivals_ms(bench, motor, "RP") == [1.042, 1.302] and send(bench, motor, "BAUD300 RBs RBf", 0.1) == b"1\r0\r"
    motor.power_cycle()
    motor.serial.host.baudrate = 9600
    assert send(bench, motor, "RP", 0.1) == b"0\r"


def test_a_reply_begins_when_the_terminator_has_been_received(bench):
    """A character of 10 bits takes 1.0417 ms at 9600 baud; three are received and two sent."""
    assert arrivals_ms(bench, clear(bench, bench.add("smartmotor")), "RP") == [4.167, 5.208]


# Channel 1


def test_rs4_takes_pin_g_as_its_direction_line(bench):
    """5.1: RS4 or OCHN(RS4,0,…) makes pin G the direction line, which is high while the motor transmits."""
    motor = clear(bench, bench.add("smartmotor"))
    levels: list[tuple[float, bool]] = []
    send(bench, motor, "RS4", 0.1)
    assert motor.pins["G"].level is False
    began = bench.now
    motor.pins["G"].subscribe(lambda pin: levels.append((round((bench.now - began) / 1e6, 3), pin.level)))
    assert send(bench, motor, "RP", 0.1) == b"0\r"
    assert levels == [(3.125, True), (5.208, False)]
    send(bench, motor, "RS2", 0.1)
    assert motor.pins["G"].level is True


# The running program


def test_a_program_waits_when_more_than_16_characters_are_to_be_sent(bench):
    """26 characters take 27.08 ms; more than 16 of them wait, so the program continues only after the last one."""
    motor = clear(bench, bench.add("smartmotor"))
    load_slowly(bench, motor, 'UAO UA=0\nPRINT("abcdefghijklmnopqrstuvwxyz")\nUA=1\nEND\n')
    motor.serial.write(b"RUN ")
    assert bench.run_until(lambda: motor.serial.read() == b"a", 0.1)
    first = bench.now
    assert bench.run_until(lambda: motor.pins["A"].level, 0.1)
    assert 25 * CHARACTER_S <= (bench.now - first) / 1e9 <= 25 * CHARACTER_S + 0.001


def load_slowly(bench: Bench, motor: Controller, program: str) -> None:
    motor.serial.write(b"LOAD ")
    bench.run(0.1)
    motor.serial.write(program.encode() + b"\xff\xff")
    bench.run(1)
    assert set(motor.serial.read()) == {6}


# Any bytes


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.one_of(st.binary(max_size=12), st.sampled_from(
    [b"\x80", b"\xfa", b"\r", b" ", b'"', b"aw[0] ", b"1 ", b"2.", b"LOAD ", b"\xff\xff", b"MD G ", b"RW ", b"ECHO "]
)), max_size=20).map(b"".join))  # fmt: skip
def test_any_bytes_are_handled_and_pieces_make_no_difference(data):
    """Received whole or byte by byte, any bytes give the same answers."""
    heard = []
    for size in (len(data) or 1, 1):
        bench = Bench()
        motor = ready(bench)
        for at in range(0, len(data), size):
            motor.serial.write(data[at : at + size])
        bench.run(0.01)
        heard.append(motor.serial.read())
    assert heard[0] == heard[1]


# OCHN's time-out


def test_the_first_motors_program_addresses_the_chain(bench):
    """Later guides: the program prints `PRINT(#128,"SADDR2",#13)` etc. to the next motor, to which its output goes."""
    motors = [bench.add("smartmotor", line="instant") for _ in range(2)]
    program = 'SADDR1 ECHO PRINT(#128,"SADDR2",#13) WAIT=400 PRINT(#130,"ECHO",#13) WAIT=400 END '
    clear(bench, motors[0])
    load(bench, motors[0], program)
    chain = bench.chain(*motors)
    for motor in motors:
        motor.power_cycle()
    bench.run(1.0)
    chain.read()
    for number in (1, 2):
        chain.write(b"%cRADDR " % (0x80 + number))
        bench.run(0.1)
        assert chain.read() == b"%cRADDR %d\r" % (0x80 + number, number)
