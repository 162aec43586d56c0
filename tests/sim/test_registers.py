"""A host at the registers of a board: what it does is told, and can be done again."""

import pytest

from axistwin.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.host_acts import HostAct, one_act
from axistwin.sim.registers import CONTROL, DATA, NOBODY_DRIVES, RegisterPort


class Board:
    """Registers, what has been written to the control byte, and what has been told."""

    def __init__(self, powered=True):
        self.port = RegisterPort(Clock())
        self.port.powered = powered
        self.controls, self.told = [], []
        self.port.on_control = self.controls.append
        self.port.on_init = lambda: self.controls.append("init")
        self.port.watch_host(self.told.append)


@pytest.fixture
def board():
    return Board()


def test_what_changes_something_is_told(board):
    board.port.output.load(b"xy")
    board.port.write(DATA, 0x41)
    board.port.write(CONTROL, 0x10)
    board.port.read(DATA)
    board.port.init()
    assert board.told == [
        HostAct("write", (DATA, 0x41)), HostAct("write", (CONTROL, 0x10)), HostAct("read"), HostAct("init"),
    ]  # fmt: skip


def test_looking_at_the_status_changes_nothing(board):
    board.port.read(CONTROL)
    assert board.told == []


def test_a_board_without_power_notices_nothing():
    board = Board(powered=False)
    board.port.write(DATA, 0x41)
    board.port.init()
    assert (board.port.read(DATA), board.told) == (NOBODY_DRIVES, [])


def test_a_wrong_access_is_no_act(board):
    with pytest.raises(UsageError, match="invalid value 256"):
        board.port.write(DATA, 256)
    assert board.told == []


def test_done_again_it_is_the_same(board):
    for one in (board, again := Board()):
        one.port.output.load(b"xyz")
    board.port.write(DATA, 0x41)
    board.port.read(DATA)
    board.port.write(CONTROL, 0x10)
    board.port.init()
    for act in board.told:
        again.port.perform(act)
    assert (again.controls, again.told) == ([0x10, "init"], board.told)
    assert (again.port.input.contents, again.port.output.contents) == (b"A", b"yz")


def test_an_act_that_no_host_can_do_is_refused(board):
    with pytest.raises(UsageError, match="unknown action 'sing'"):
        board.port.perform(HostAct("sing"))


def test_whoever_attends_to_a_change_of_status_at_once_is_part_of_the_act_that_made_it(board):
    board.port.on_control = lambda value: setattr(board.port, "status", value)
    board.port.subscribe_status(lambda: board.port.write(DATA, 0x42))
    board.port.write(CONTROL, 0x10)
    assert (board.told, board.port.input.contents) == ([HostAct("write", (CONTROL, 0x10))], b"B")


def test_several_things_can_be_made_one_act_that_somebody_else_tells(board):
    with one_act(board.port.clock) as outermost:
        board.port.write(DATA, 0x41)
        with one_act(board.port.clock) as inner:
            board.port.write(DATA, 0x42)
        board.port.write(DATA, 0x43)
    assert (outermost, inner, board.told) == (True, False, [])
    board.port.write(DATA, 0x44)
    assert len(board.told) == 1
