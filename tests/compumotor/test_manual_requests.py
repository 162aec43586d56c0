"""Manual, Appendix A: 80h to 97h (requests) and A0h to AFh (interrupts on events)."""

import pytest

from ..scripts import scripts
from .programs import continuous, cruise, relative
from .scripts import play
from .talking import ask, complete, default, i32, messages, position, send, send_all


def byte(bench, board, *command):
    """Return the second byte of a reply; fourteen zeros must follow."""
    data = ask(bench, board, *command)
    assert data[0] == command[0] and data[2:] == bytes(14)
    return data[1]


def test_positions_on_the_way(bench, board):
    """80h, 81h during a move: pulses done and pulses left add up to the whole distance."""
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(-5_000), seconds=0.2)
    early, done = board.axes["motor"].position, position(bench, board, 0x80)
    missing, late = position(bench, board, 0x81), board.axes["motor"].position
    assert late <= done <= early <= 0 and 5_000 + late <= missing <= 5_000 + done


def test_an_excursion_of_several_continuous_moves_is_one(bench, board):
    """80h: "from zero velocity, to nonzero velocity, and back to zero velocity"."""
    cruise(bench, board)
    send_all(bench, board, continuous(2, 5_000, 100_000), (0x40, 2), seconds=0.2)
    complete(bench, board, 0x70)
    assert position(bench, board, 0x80) == board.axes["motor"].position


@scripts({
    "83h: ten pulses beyond 7FFFFFFFh are 80000009h, in six bytes":
    "default 10000 1000000; 2E =at_once; 33 =10; idle; 83: 2147483657",
    "84h, 8Bh: 00 is +, FF is -; at rest they report the most recent direction":
    "cruise {10000|-10000} 100000; 84 -> {00|FF}; 8B -> {00|FF}; 78; 84 -> {00|FF}; 8B -> {00|FF}; 78",
    "90h: 50h is indexer mode; another mode is reported with its parameters":
    "90 -> 50; 51 09 10 00 00 00 64; 90 -> 51 09 10 00 00 00 64; 52 01 04 01 02 03 04 00 02; "
    "90 -> 52 01 04 01 02 03 04 00 02; 53 03 01 00 00 00 00 FF FF; 90 -> 53 03 01 00 00 00 00 FF FF; 50; 90 -> 50",
    'A0h to A3h: "the current move will not cause an interrupt"; A4h and A5h make no such exception (1)':
    "default 10000 20000; 33 =8000; 0.2 s; {A0|A1|A2|A3} 01; idle; says nothing; 33 =8000; idle; says {A0|A1|A2|"
    "A3} 00",
    'A0h to A3h: "the current move will not cause an interrupt"; A4h and A5h make no such exception (2)':
    "default 10000 20000; 33 =8000; 0.2 s; {A4|A5} 01; idle; says {A4|A5} 00",
    'ACh: "this command followed by the parameter byte (a 01 or a 06)"; it stays enabled until it is turned off':
    "AC {01|06} 01; trigger {1|6}; trigger {6|1}; says AC {01|06}; trigger {1|6}; trigger {6|1}; says AC {01|06}; "
    "AC {01|06} 00; trigger {1|6}; says nothing; AC {01|06} 01; AF; trigger {1|6}; says nothing",
    "requests that streaming modes do not know: 92h and 93h are not valid in streaming modes; 91h is valid for "
    "move 00 only":
    "relative 3 10 10 10; default 10 10; 51 01 04 00 00 00 00; 92 01 -> nothing; 93 -> nothing; 91 03 -> nothing; "
    "91 00 -> CE 00 00 =10 =10",
    "80h to 83h after moves of 300 and -500: -500 from the start, 0 to the end, -200 from home and from zero":
    "default 10000 1000000; 33 =300; idle; 33 =-500; idle; 80 -> FF FF FE 0C; 81 -> 00; 82 -> FF FF FF FF FF 38; "
    "83 -> FF FF FF FF FF 38",
    "89h: the high nibble is the + limit; 88h: the limits are bits 0 and 1":
    "cw_limit {low|high|low|high}; ccw_limit {low|low|high|high}; 0.01 s; 89 -> {00|F0|0F|FF}; 88 & 03 is {00|01|"
    "02|03}",
    "8Ah: active is the level that 38h defines; 88h: the home switch is bit 2":
    "38 {00|01} 00 0A 00; home high; 0.01 s; 8A -> {00|FF}; 88 & 04 is {00|04}; home low; 0.01 s; 8A -> {FF|00}; "
    "88 & 04 is {04|00}; home high; 0.01 s; 8A -> {00|FF}; 88 & 04 is {00|04}",
    'A5h: its message causes the "message ready" interrupt, which CB bit seven clears':
    "default 10000 100000; A5 01; 33 =100; CB 40; no interrupt; idle; 0.01 s; interrupt; SB & C8 is 88; ODB A5; "
    "CB C0; no interrupt",
    "Attributes of these requests: valid in both modes and concurrent with a sequence":
    "D9 01; 2B 00 01; D8; 41 01; {80|82|83|84|85|88|89|8A|8B|8C|94|95|96|97|FD} answers; 79; "
    "52 01 04 00 00 00 00 00 02; {80|82|83|84|85|88|89|8A|8B|8C|94|95|96|97|FD} answers",
})  # fmt: skip
def test_requests_and_events(bench, script):
    play(bench, script)


def test_velocity_on_a_ramp(bench, board):
    """85h: a positive number in units of the range, in either direction; zero at rest."""
    send(bench, board, *continuous(1, 100_000, 50_000, minus=1, ranges=0x10))  # 10,000 pps at 5,000 pps²
    bench.run(0.05)
    send(bench, board, 0x40, 1, seconds=1)
    early = -board.axes["motor"].velocity * 10
    data = ask(bench, board, 0x85)
    late = -board.axes["motor"].velocity * 10
    assert data[:2] == b"\x85\x10" and early - 17 <= int.from_bytes(data[2:6], "big") <= late + 17
    send(bench, board, 0x78)
    assert ask(bench, board, 0x85)[2:6] == bytes(4)


def phases(bench, board, minus=0):
    """Return the replies of 88h and 8Ch to 8Fh at rest, on both ramps, and between the ramps."""
    send(bench, board, *continuous(1, 10_000, 20_000, minus), seconds=0.05)

    def look():
        return byte(bench, board, 0x88), *(byte(bench, board, opcode) for opcode in (0x8C, 0x8D, 0x8E, 0x8F))

    rows = [look()]
    for command, wait in (((0x40, 1), 0.2), ((0x00,), 0.6), ((0x70,), 0.1), ((0x00,), 1)):
        send(bench, board, *command, seconds=wait)
        rows.append(look())
    return rows


@pytest.mark.parametrize("minus", [0, 1])
def test_move_status(bench, board, minus):
    """88h: bit 3 is - direction, 4 moving, 5 constant, 6 accelerating, 7 decelerating; 8Ch to 8Fh report each."""
    home = byte(bench, board, 0x88) & 4
    rows = phases(bench, board, minus)
    sign = 8 * minus
    assert rows == [
        (home, 0, 0, 0, 0), (home | sign | 0x50, 0xFF, 0, 0xFF, 0), (home | sign | 0x30, 0xFF, 0xFF, 0, 0),
        (home | sign | 0x90, 0xFF, 0, 0, 0xFF), (home | sign, 0, 0, 0, 0),
    ]  # fmt: skip


def test_crunching(bench, board):
    """93h: the reply is 00 until all definitions have been "crunched"."""
    assert byte(bench, board, 0x93) == 0xFF
    for number in range(1, 51):
        send(bench, board, *relative(number, 10_000, 100_000, 10))
    assert byte(bench, board, 0x93) == 0
    bench.run(1)
    assert byte(bench, board, 0x93) == 0xFF


def events(bench, board):
    """Return every event, in order, of a trapezoid, a triangle, and a continuous move that is stopped."""
    default(bench, board, 10_000, 100_000)
    for command in ((0x33, *i32(3_000)), (0x33, *i32(-200)), (0x32, 0), (0x70,)):
        send(bench, board, *command, seconds=1)
    return messages(bench, board)


@pytest.mark.parametrize(("opcode", "expected"), [(0xA0, 1), (0xA1, 3), (0xA2, 1), (0xA3, 2), (0xA4, 1), (0xA5, 3)])
def test_events_of_moves(bench, board, opcode, expected):
    """A0h to A5h: "this command followed by fifteen zeroes"; a triangle reaches no constant velocity."""
    send(bench, board, opcode, 0xFF)
    assert events(bench, board) == [f"{opcode:02x} 00"] * expected
    assert events(bench, board) == ([f"{opcode:02x} 00"] * expected if opcode & 1 else [])
    send_all(bench, board, (opcode, 1), (opcode, 0))
    assert events(bench, board) == []
    send_all(bench, board, (opcode, 1), (0xAF,))
    assert events(bench, board) == []


@pytest.mark.parametrize(("next_", "every", "pin"), [
    (0xA8, 0xA9, "cw_limit"), (0xAA, 0xAB, "ccw_limit")], ids=["plus", "minus"])  # fmt: skip
def test_hitting_a_limit(bench, board, next_, every, pin):
    """A8h to ABh: a limit that is already active at the time of the command causes no message."""

    def hit():
        cruise(bench, board, minus=pin == "ccw_limit")
        board.pins[pin].drive(True)
        bench.run(0.01)
        found = messages(bench, board)
        board.pins[pin].drive(False)
        bench.run(0.01)
        return found

    send(bench, board, next_, 1)
    assert [hit(), hit()] == [[f"{next_:02x} 00"], []]
    send(bench, board, every, 1)
    assert [hit(), hit()] == [[f"{every:02x} 00"], [f"{every:02x} 00"]]
    send(bench, board, 0xAF)
    assert hit() == []
    board.pins[pin].drive(True)
    bench.run(0.01)
    send(bench, board, every, 1, seconds=0.1)
    assert messages(bench, board) == []
