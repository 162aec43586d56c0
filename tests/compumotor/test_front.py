"""Every lamp on the front panel of an 1811, lit and dark in the situations that the manual describes."""

import pytest

from axistwin import Bench
from axistwin.core.units import US

from ..fronts import lamps, shown
from .programs import cruise
from .talking import CONTROL, ENABLE, ready, send, status_word, write

STATUS, BOARD, MOVE, OUTPUTS = "Status byte", "Board", "Move status 88h", "Outputs"
INPUTS, JOYSTICK, LINES, ENCODER = "Limits and triggers", "Joystick", "Interrupt lines", "Encoder"


def command(*values):
    return lambda bench, board: (send(bench, board, *values), bench.run(0.01))


def drive(pin, level):
    return lambda bench, board: board.pins[pin].drive(level)


def interrupted(bench, board):
    """Enable interrupts, and make a message ready."""
    board.bus.write(CONTROL, ENABLE)
    write(board, 0x84, control=ENABLE)
    bench.run(0.02)


def failed(bench, board):
    """Let the test function FFh run: 5 s in each direction, and then the board monitor alarm."""
    send(bench, board, 0xFF, seconds=10.1)


def moving_minus(bench, board):
    cruise(bench, board, minus=1)


def decelerating(bench, board):
    cruise(bench, board)
    send(bench, board, 0x70, seconds=0.01)


def accelerating(bench, board):
    cruise(bench, board)
    send(bench, board, 0x31, 0, 0, *(20_000).to_bytes(4, "big"), *(10_000).to_bytes(4, "big"))
    send(bench, board, 0x32, 0, seconds=0.05)


def at_a_pulse(bench, board, minus=0):
    """Run to a pulse; STEP is high for half a period of 546 kHz."""
    cruise(bench, board, minus=minus)
    for _ in range(300):
        bench.clock.run_to(bench.now + US // 2)
        if board.terminals["step"].level:
            return


def joystick_enabled(bench, board):
    board.pins["at_zero"].drive(True)
    command(0x11)(bench, board)


def stick(bench, board):
    board.joystick.deflect(1000)
    bench.run(0.02)


SITUATIONS = {
    (STATUS, "7"): interrupted, (STATUS, "5"): failed, (STATUS, "3"): command(0x84), (STATUS, "2"): command(0x09, 2),
    (STATUS, "1"): command(0x09, 1), (STATUS, "0"): command(0x09, 0), (BOARD, "ALARM"): failed,
    (BOARD, "INT"): interrupted, (MOVE, "+"): drive("cw_limit", True), (MOVE, "−"): drive("ccw_limit", True),
    (MOVE, "DIR −"): moving_minus, (MOVE, "MOV"): cruise, (MOVE, "CONST"): cruise, (MOVE, "ACC"): accelerating,
    (MOVE, "DEC"): decelerating, (OUTPUTS, "RPS"): command(0x12, 1), (OUTPUTS, "CW"): cruise,
    (OUTPUTS, "STEP"): at_a_pulse, (OUTPUTS, "CW STEP"): at_a_pulse,
    (OUTPUTS, "CCW STEP"): lambda bench, board: at_a_pulse(bench, board, minus=1), (LINES, "JU18"): command(0x84),
    (LINES, "JU19"): failed, (INPUTS, "CW"): drive("cw_limit", True), (INPUTS, "CCW"): drive("ccw_limit", True),
    (JOYSTICK, "REQ"): drive("remote_enable", False), (JOYSTICK, "ACK"): joystick_enabled,
}  # fmt: skip
"""Actions that light a lamp which is dark on an idle board."""
LIT_WHEN_READY = {
    (STATUS, "6"): lambda bench, board: board.bus.write(CONTROL, ENABLE),
    (STATUS, "4"): lambda bench, board: write(board, 0x00),
    (MOVE, "HOME"): drive("home", False),
    (OUTPUTS, "1"): command(0x0C, 1),
    (OUTPUTS, "2"): command(0x0C, 2),
    (LINES, "JU20"): lambda bench, board: write(board, 0x00),
    **{(INPUTS, f"{n}"): drive(f"trigger{n}", False) for n in range(1, 7)},
    (JOYSTICK, "ZERO"): stick,
}
"""Actions that switch off a lamp which is lit on an idle board."""


@pytest.mark.parametrize("lamp", SITUATIONS, ids=" ".join)
def test_a_lamp_is_lit_when_the_manual_says_so(bench, board, lamp):
    assert shown(board, *lamp) is False
    SITUATIONS[lamp](bench, board)
    assert shown(board, *lamp) is True


@pytest.mark.parametrize("lamp", LIT_WHEN_READY, ids=" ".join)
def test_a_lamp_that_is_lit_when_it_is_ready_goes_out(bench, board, lamp):
    assert shown(board, *lamp) is True
    LIT_WHEN_READY[lamp](bench, board)
    assert shown(board, *lamp) is False


@pytest.mark.parametrize("model", ["1810", "1811"])
def test_there_is_no_lamp_without_a_situation(model):
    encoder = {(ENCODER, label) for label in ("Z", "STEP", "DIR")} if model == "1811" else set()
    assert lamps(Bench().add(model)) == SITUATIONS.keys() | LIT_WHEN_READY.keys() | encoder


def test_the_lamps_of_the_encoder(bench):
    """Encoder connector: CH. Z is lit once a revolution, STEP OUT at each count, DIRECTION OUT in one direction."""
    encoder = {"counts_per_rev": 4000, "pulses_per_rev": 25_000}
    board = ready(bench, motor={"encoder": encoder})
    assert shown(board, ENCODER, "Z") is True  # the mark is at count 0
    cruise(bench, board, velocity=5_000, minus=1)
    assert [shown(board, ENCODER, label) for label in ("Z", "DIR")] == [False, False]
    count = board.axes["motor"].encoder.count
    while board.axes["motor"].encoder.count == count:
        bench.clock.run_to(bench.now + 200)
    assert shown(board, ENCODER, "STEP") is True
    bench.clock.run_to(bench.now + 229)
    assert shown(board, ENCODER, "STEP") is False
    send(bench, board, 0x78)
    cruise(bench, board, velocity=5_000)
    assert shown(board, ENCODER, "DIR") is True


def test_the_status_byte_from_bit_7_to_bit_0_is_what_the_host_reads(bench, board):
    for situation in (command(0x08, 5), interrupted):
        situation(bench, board)
        byte = "".join(str(int(shown(board, STATUS, f"{bit}"))) for bit in range(7, -1, -1))
        assert int(byte, 2) == status_word(bench, board)


@pytest.mark.parametrize(("act", "label", "word"), [
    (command(0x50), "mode", "50h indexer"),
    (command(0x51, 1, 4, 0, 0, 0, 0), "mode", "51h velocity-distance streaming"),
    (command(0x52, 1, 4, 0, 0, 0, 0, 0, 10), "mode", "52h velocity-time streaming"),
    (command(0x53, 1, 4, 0, 0, 0, 0, 0, 10), "mode", "53h distance-time streaming"),
    (cruise, "motion", "constant, non-zero velocity"),
    (decelerating, "motion", "decelerating"),
    (lambda bench, board: board.power(False), "mode", "no power"),
    (lambda bench, board: board.power(False), "motion", "no power"),
    (command(0x84), "ODB", "84 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
    (lambda bench, board: board.bus.write(0, 0x84), "IDB", "84"),
    (command(0x00), "IDB", "empty")])  # fmt: skip
def test_what_the_board_says_in_words(bench, board, act, label, word):
    act(bench, board)
    assert shown(board, BOARD, label) == word


def test_no_joystick_requests_nothing(bench, board):
    """95h: "no Joystick is attached ... there will be no Joystick request"; Joystick: REMOTE ENABLE is active low."""
    assert shown(board, JOYSTICK, "REQ") is False
    send(bench, board, 0x95, seconds=0.01)
    assert [board.bus.read(0), board.bus.read(0)] == [0x95, 0xFF]


def test_the_board_tells_that_the_joystick_moves_the_motor(bench, board):
    """11h: the joystick's pulses pass through the board; 88h reports bit 4, moving, too."""
    command(0x11)(bench, board)
    stick(bench, board)
    assert shown(board, BOARD, "motion") == "moved by the joystick" and shown(board, MOVE, "MOV") is True
    board.joystick.deflect(0)
    bench.run(0.02)
    assert shown(board, BOARD, "motion") == "zero velocity"


def test_without_power_the_status_byte_and_the_buffers_are_dark(bench, board):
    """The Status Byte is a register of the board, so it is dark without power; a host then reads the floating bus."""
    command(0x09, 1)(bench, board)
    command(0x84)(bench, board)
    board.bus.write(0, 0x84)
    board.power(False)
    assert not [lamp for lamp in lamps(board) if lamp[0] in (STATUS, BOARD, MOVE, OUTPUTS) and shown(board, *lamp)]
    assert [shown(board, BOARD, label) for label in ("IDB", "ODB")] == ["empty", "empty"]


def test_commands_that_wait_are_counted(bench):
    """The command in progress needs 4 ms by default, here 1 s; meanwhile three more commands wait and are counted."""
    board = ready(bench, reply_ms=1000.0)
    for _ in range(4):
        send(bench, board, 0x84)
    assert shown(board, BOARD, "commands waiting") == "3"
