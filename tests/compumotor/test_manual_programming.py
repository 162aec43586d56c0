"""Manual, chapter Programming: B Reading and writing, C Control and status bytes, D Interrupts, E Modes, F Syntax."""

from itertools import cycle, repeat

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS

from ..scripts import scripts
from .programs import relative, sequence
from .scripts import play
from .talking import CONTROL, DATA, MESSAGE, TAKEN, ask, message, messages, ready, send, status_word, write


@scripts({
    'B.1: "1) read the SB and check bit four; 2) write the command string into the IDB; 3) write to the CB, bit 4"':
    "SB & 10 is 10; IDB 09; IDB 02; 0.1 s; SB 50 -- nothing happens before bit four says so; CB 10; SB 40; 0.1 s; "
    "SB 54",
    'B.3: "requesting the state of the Trigger bits nets a response only two bytes long"':
    "trigger2 high; trigger3 low; trigger4 low; trigger5 high; 94 -> 24",
    'C.2: "Bit 6 of the SB reflects the inverse of bit 6 of the CB"; bits 0 to 3 of the CB are unused':
    "CB {00|40|80|C0|0F|4F}; SB & 40 is {40|0|40|0|40|0}; 0.1 s; SB {50|10|50|10|50|10}",
    "D: the printed assembly lines keep the interrupt enable bit: 50h leaves it set, 10h clears it":
    "IDB 90; CB 50; 0.05 s; interrupt; SB 98; CB C0; 0.05 s; no interrupt; SB 10; IDB 90; CB 10; 0.05 s; "
    "no interrupt",
    "D: with jumper JU18 alone, an empty IDB causes no interrupt, only a ready message does":
    "CB 40; 0.1 s; no interrupt",
    'D: "whenever these conditions are met and the IDB is empty ... To clear the interrupt, you must set bit four"':
    "1811 interrupts=('input_ready',); no interrupt; CB 40; interrupt; IDB 09 00; CB 50; no interrupt; 0.01 s; "
    "interrupt; SB & 7 is 1",
    "D, the listing's comment: \"In about one millisecond the buffer will become available\"":
    "IDB 00; CB 10; clock; until SB & 10 is 10; 0.5 to 2 ms later",
    'F: "perform move number 5" as `40 05` and as `40 05` with zeros to the end':
    "relative 5 10000 100000 1000; mark; 40 05; 1 s; moved 1000; mark; "
    "40 05 00 00 00 00 00 00 00 00 00 00 00 00 00 00; 1 s; moved 1000",
    'F: "Using any other character will cause the command to be ignored"; B: so are "missing parameter bytes" (1)':
    "relative 5 10000 100000 1000; 40 05 00 07; 1 s; pulses 0; says nothing",
    'F: "Using any other character will cause the command to be ignored"; B: so are "missing parameter bytes" (2)':
    "relative 5 10000 100000 1000; 40; 1 s; pulses 0; says nothing",
    'F: "Using any other character will cause the command to be ignored"; B: so are "missing parameter bytes" (3)':
    "relative 5 10000 100000 1000; 40 05 00 00 00 00 00 00 00 00 00 00 00 00 00 01; 1 s; pulses 0; says nothing",
    'E.2: "a SINGULAR command cannot be performed outside of a sequence buffer during sequence buffer execution"':
    "relative 1 10000 100000 500; sequence 1: 28 00, 09 00; 41 01; 40 01; 0C 01; 0.5 s; pulses 0; output1 is low; "
    "48; 40 01; 0.5 s; pulses 500",
    'B.2: "If the Motor Controller has been waiting to send additional messages ... it will do so then"':
    "01 11; 01 22; 0.1 s; ODB 01; ODB 11; CB 80; next 01 22",
    'C.2, the table: only bits 4 and 6 are set; "power-up initialization takes about one second"':
    "new 1811; 0.5 s; SB & 10 is 0; until SB & 10 is 10; SB 50",
    'C.1: "equivalent to cycling power to the board or activating the Multibus reset line"':
    "relative 3 1000 1000 100; 08 05; 0D 00; sequence 2: 40 03; {CB|bus|power} {20|init|cycle}; 0.5 s; "
    "SB & 10 is 0; 0.6 s; SB 50; 97 -> 06; 40 03; 41 02; 0.5 s; pulses 0",
})  # fmt: skip
def test_registers_and_strings(bench, script):
    play(bench, script)


def test_reading_in_six_steps(bench, board):
    """B.2, steps four to six: SB bit three, the message of the ODB, CB bit seven."""
    write(board, 0x97)
    assert bench.run_until(lambda: status_word(bench, board) & MESSAGE, 0.1)
    assert bytes(board.bus.read(DATA) for _ in range(16)) == bytes([0x97, 0x06]).ljust(16, b"\0")
    assert status_word(bench, board) & MESSAGE, "the board can not know before it is told"
    board.bus.write(CONTROL, TAKEN)
    bench.run(0.01)
    assert status_word(bench, board) == 0x50


def test_a_command_without_its_attribute_stays_out_of_the_sequence(bench, board):
    """E.2: "Attempting to place a command without this attribute into a sequence buffer will cause [it] to be ignored".

    30, 41, 48, 70, 71, 78, 80 and D6 are not valid within a sequence.
    """
    alien = [(0x30,), (0x41, 1), (0x48,), (0x70,), (0x71,), (0x78,), (0x80,), (0xD6, 0, 0, 0, 1)]
    sequence(bench, board, 1, *alien, (0x09, 1), *alien)
    send(bench, board, 0x92, 1)
    assert messages(bench, board) == ["92 09 01", "92 00"]


COMMANDS = st.sampled_from([
    (0x01, 0x5A), (0x08, 5), (0x09, 1), (0x0A, 0), (0x0C, 1), (0x0F, 1, 1, 1), (0x30,), (0x80,), (0x83,), (0x85,),
    (0x88,), (0x90,), (0x91, 0), (0x91, 7), (0x97,), (0xA5, 1), (0xAF,), (0xD6, 0, 0, 1, 0), (0xE2,), (0xFD,),
    (0x31, 0, 0, 0, 0, 0x27, 0x10, 0, 1, 0x86, 0xA0), (0x33, 0, 0, 1, 0), (0x33, 0xFF, 0xFF, 0xFF, 0),
    relative(7, 5_000, 50_000, -300), (0x40, 7), (0x70,), (0x78,), (0x73,),
])  # fmt: skip


def hear(commands, gaps):
    """Send commands 20 ms apart, with any pauses between their bytes; return everything that resulted."""
    bench = Bench()
    board, heard = ready(bench), []
    for command in commands:
        due = bench.now + 20 * MS
        for value in command:
            bench.run(next(gaps) / 1_000_000)
            board.bus.write(DATA, value)
        bench.run((due - bench.now) / 1_000_000_000)
        board.bus.write(CONTROL, 0x10)
        if data := message(bench, board, 0.01):
            heard.append((bench.now, data))
    bench.run(1)
    return heard, messages(bench, board), status_word(bench, board), [int(t) for t in board.axes["motor"].pulse_times()]


@settings(max_examples=20, deadline=None)
@given(st.lists(COMMANDS, max_size=12), st.lists(st.integers(0, 1_300), min_size=1, max_size=40))
def test_the_pace_of_the_bytes_does_not_matter(commands, gaps):
    """B.1: the board reads the IDB when bit four is written, and not before."""
    assert hear(commands, repeat(0)) == hear(commands, cycle(gaps))


@settings(max_examples=20, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, 1), st.booleans(), st.one_of(st.integers(0, 255), COMMANDS), st.integers(0, 4_000)),
        max_size=60,
    )
)
def test_whatever_is_written_or_read_whenever(acts):
    """Any bytes are written and read at any time: the status byte stays valid, and a reset restores the board."""
    bench = Bench()
    board = bench.add("1811", interrupts=("message_ready", "input_ready", "failed"))
    for offset, look, value, wait_us in acts:
        if isinstance(value, tuple):
            for byte in value:
                board.bus.write(DATA, byte)
            value = 0x50
        board.bus.write(offset, value)
        if look:
            assert 0 <= board.bus.read(DATA) <= 255 and 0 <= status_word(bench, board) <= 255
        bench.run(wait_us / 1_000_000)
    board.bus.write(CONTROL, 0x20)
    bench.run(1.01)
    assert status_word(bench, board) == 0x50 and ask(bench, board, 0x83) == bytes([0x83]).ljust(16, b"\0")
