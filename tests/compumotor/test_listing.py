"""Listings of the sequence buffers, the running command, and the time at which each command begins."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS

from .talking import default, i32, send, send_all

NO_TIME = 0x7FFF_FFFF


def define(bench: Bench, board: Controller, number: int, *commands: tuple[int, ...]) -> None:
    send(bench, board, 0xD9, number)
    for command in commands:
        send(bench, board, *command)
    send(bench, board, 0xD8)


def perform(bench: Bench, board: Controller, number: int, seconds: float = 1.0) -> list[tuple[int, str, int]]:
    """Return each command that begins within `seconds`: time in ns after the first, sequence, and command from 1 on."""
    found: list[tuple[int, str, int]] = []

    def watch(program: str, index: int) -> None:
        assert board.programs[program].running == index
        began_ns = bench.now - (found[0][0] if found else 0)
        found.append((began_ns, program, index + 1))

    look_away = board.subscribe_lines(watch)
    send(bench, board, 0x41, number, seconds=seconds)
    look_away()
    return [(0, *found[0][1:]), *found[1:]] if found else []


def begun(bench: Bench, board: Controller, number: int, seconds: float = 1.0) -> list[tuple[float, int]]:
    """Return time (ms) and number of each command that begins in a single sequence."""
    found = perform(bench, board, number, seconds)
    assert {program for _, program, _ in found} <= {f"sequence {number}"}
    return [(time_ns / MS, command) for time_ns, _, command in found]


def running(board: Controller) -> dict[str, int]:
    """Return, for each sequence that is performed, the number of its running command, from 1 on."""
    return {name: found.running + 1 for name, found in board.programs.items() if found.running is not None}


def registers(board: Controller) -> tuple[int, int]:
    return board.registers["sequence"].read(), board.registers["command"].read()


def test_a_register_is_a_number_or_a_text(board):
    for name, register in board.registers.items():
        assert isinstance(register.read(), str if register.text else int), name


# Lines


def test_a_board_that_was_just_switched_on_has_no_sequences(board):
    assert board.programs == {} and registers(board) == (0, 0)


def test_a_command_is_listed_in_hex_and_in_words(bench, board):
    """Each line of a sequence is a command in hex and in words; the hex can be sent as a command."""
    define(bench, board, 15, (0x33, *i32(25_000)), (0x2A, 0, 2), (0x2C, 3, 1), (0x0B, 1, 0, 0))
    listing = board.programs["sequence 15"]
    assert listing.title == "sequence 15"
    assert listing.lines == (
        "33 00 00 61 A8 ; go relative: distance 25000 pulses", "2A 00 02 ; wait seconds: time 2 s",
        "2C 03 01 ; wait for trigger: trigger 3, level 1", "0B 01 ; set output: output 1",
    )  # fmt: skip
    language = board.product.language
    assert language.read(listing.lines[0]) == bytes([0x33, *i32(25_000)]) and listing.running is None


def test_only_what_has_a_definition_is_there(bench, board):
    """DAh removes a sequence from the list; a sequence that is defined without commands is in the list."""
    define(bench, board, 7, (0x0B, 1))
    define(bench, board, 2)
    define(bench, board, 11, (0x0C, 1))
    send(bench, board, 0xDA, 11)
    assert list(board.programs) == ["sequence 2", "sequence 7"] and board.programs["sequence 2"].lines == ()


def test_what_is_being_defined_is_marked(bench, board):
    """D9h to D8h: the old contents are gone, and commands that are not valid in a sequence are not stored."""
    define(bench, board, 4, (0x0B, 1))
    send_all(bench, board, (0xD9, 4), (0x0C, 2), (0x70,))
    listing = board.programs["sequence 4"]
    assert (listing.title, listing.lines) == ("sequence 4, being defined", ("0C 02 ; clear output: output 2",))
    send(bench, board, 0xD8)
    assert board.programs["sequence 4"].title == "sequence 4"


def test_a_command_for_which_there_was_no_room_is_not_there(bench):
    """Option buffer_bytes=16: the buffer has room for three moves of five bytes each."""
    board = bench.add("1810", buffer_bytes=16)
    bench.run(1.01)
    define(bench, board, 1, *[(0x33, *i32(distance)) for distance in (1, 2, 3, 4)])
    assert [line[:14] for line in board.programs["sequence 1"].lines] == [f"33 00 00 00 0{n}" for n in (1, 2, 3)]


def test_a_streaming_mode_has_no_sequences_and_its_buffer_is_no_program(bench, board):
    """51h "destroys" the sequences; the streaming buffer is not listed, because no command reads it."""
    define(bench, board, 1, (0x0B, 1))
    send_all(bench, board, (0x51, 1, 1, 0, 0, 0, 0), (0xE0, *(0x10, 0, 0, 10) * 3))
    assert board.programs == {}


# Running


def test_a_command_begins_when_the_one_before_is_finished(bench, board):
    """The processor needs 1 ms (`step_ms`) for each command, before the command's own time, e.g. 5 ms of 29h."""
    define(bench, board, 3, (0x0B, 1), (0x29, 0, 0, 0, 5), (0x0C, 1), (0x0B, 2))
    assert begun(bench, board, 3) == [(0, 1), (1, 2), (7, 3), (8, 4)] and running(board) == {}
    assert registers(board) == (0, 0)


def test_a_loop_begins_its_commands_again(bench, board):
    """20h repeats the next two commands twice; each takes 1 ms."""
    define(bench, board, 1, (0x20, 2, 0, 2), (0x0B, 1), (0x0C, 1), (0x0B, 2))
    assert begun(bench, board, 1) == [(0, 1), (1, 2), (2, 3), (3, 2), (4, 3), (5, 4)]


def test_a_loop_until_continue_goes_round(bench, board):
    """21h repeats one command; after CONTINUE the loop ends when the command has been performed once more."""
    define(bench, board, 1, (0x21, 1), (0x29, 0, 0, 0, 99), (0x0C, 1))
    assert begun(bench, board, 1, 0.45) == [(0, 1), (1, 2), (101, 2), (201, 2), (301, 2), (401, 2)]
    assert (running(board), registers(board)) == ({"sequence 1": 2}, (1, 2))
    send(bench, board, 0x48, seconds=0.07)
    assert running(board) == {}


def test_the_running_command_is_that_of_now(bench, board):
    """2Bh and 28h are the running command as long as they wait."""
    define(bench, board, 9, (0x2B, 0, 1), (0x28, 0))
    perform(bench, board, 9, 30)
    assert (running(board), registers(board)) == ({"sequence 9": 1}, (9, 1))
    bench.run(31)
    assert running(board) == {"sequence 9": 2}
    bench.run(3600)
    assert running(board) == {"sequence 9": 2}
    send(bench, board, 0x48, seconds=0.002)
    assert running(board) == {}


def test_a_move_runs_until_it_has_ended(bench, board):
    """A SINGULAR command ends before the next begins: 5,000 pulses at 10,000 pulses/s without ramps are 0.5 s."""
    default(bench, board, 10_000, NO_TIME)
    define(bench, board, 1, (0x33, *i32(5000)), (0x0C, 1))
    board.pins["output1"].subscribe(lambda pin: ends.append((bench.now, board.axes["motor"].position)))
    ends: list[tuple[int, int]] = []
    times: list[int] = []
    board.subscribe_lines(lambda program, index: times.append(bench.now))
    send(bench, board, 0x41, 1, seconds=1)
    assert ends == [(times[1] + 1 * MS, 5000)], "the second command is carried out 1 ms after it has begun"


def test_a_suspended_sequence_stands_at_the_command_that_is_finished(bench, board):
    """72h: the present command is finished, and remains the running one until CONTINUE."""
    define(bench, board, 1, (0x29, 0, 0, 1, 0), (0x29, 0, 0, 1, 0))
    perform(bench, board, 1, 0.01)
    send(bench, board, 0x72, seconds=10)
    assert running(board) == {"sequence 1": 1}
    send(bench, board, 0x48, seconds=0.01)
    assert running(board) == {"sequence 1": 2}


def test_kill_and_discontinue_end_it(bench, board):
    """79h ends a sequence at once, 71h when the present command is finished."""
    define(bench, board, 1, (0x29, 0, 0, 1, 0), (0x0C, 1))
    perform(bench, board, 1, 0.01)
    send(bench, board, 0x79)
    assert running(board) == {} and begun(bench, board, 1, 0.01) == [(0, 1)]
    send(bench, board, 0x71)
    assert running(board) == {"sequence 1": 1}
    bench.run(0.3)
    assert running(board) == {}
    assert board.pins["output1"].level is True, "the second command has not been performed"


def test_sequences_do_not_nest_and_stay_as_they_are_while_one_is_performed(bench, board):
    """While a sequence is performed, 41h, D9h and DAh from the host are ignored; within a sequence they are invalid."""
    define(bench, board, 1, (0x29, 0, 0, 1, 0), (0x41, 2), (0x0B, 1))
    define(bench, board, 2, (0x0C, 1))
    before, found = board.programs, perform(bench, board, 1, 0.1)
    for command in ((0x41, 2), (0xDA, 1), (0xD9, 1), (0xDA, 2)):
        send(bench, board, *command)
    assert running(board) == {"sequence 1": 1}
    bench.run(0.3)
    assert board.programs == before
    assert [program for _, program, _ in found] == ["sequence 1"]
    assert len(before["sequence 1"].lines) == 2


def test_an_empty_or_an_unknown_sequence_begins_nothing(bench, board):
    define(bench, board, 2)
    assert perform(bench, board, 2, 0.1) == [] and perform(bench, board, 3, 0.1) == []


@pytest.mark.parametrize("how", ["power", "reset"])
def test_power_and_reset_lose_everything(bench, board, how):
    """A reset has the same effect as switching the power off and on."""
    define(bench, board, 5, (0x2B, 0, 1))
    perform(bench, board, 5, 1)
    assert running(board) == {"sequence 5": 1}
    if how == "power":
        board.power(False)
    else:
        board.bus.write(1, 0x20)
    assert board.programs == {} and registers(board) == (0, 0)


def test_a_watcher_stays_through_a_reset(bench, board):
    found = []
    board.subscribe_lines(lambda program, index: found.append((program, index)))
    board.power_cycle()
    bench.run(1.1)
    define(bench, board, 1, (0x0B, 1))
    send(bench, board, 0x41, 1, seconds=0.1)
    assert found == [("sequence 1", 0)]
