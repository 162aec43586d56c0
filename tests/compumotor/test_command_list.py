"""Appendices A and E, command summaries: an independent list, and all 256 opcodes."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import product

from .talking import RESET, ask, message, ready, send, send_all

LIST = Path(__file__).parents[1] / "manual" / "1811.txt"
ROWS = [line.split() for line in LIST.read_text().splitlines() if not line.startswith("#")]
LISTED = [(int(opcode, 16), int(size, 16)) for opcode, size, _ in ROWS]
UNDEFINED = sorted({*range(0x100)} - {opcode for opcode, _ in LISTED})


def test_the_table_has_the_manuals_commands_in_the_manuals_order():
    assert [(command.code, command.size) for command in product("1811").commands] == LISTED


def test_the_1810_has_the_commands_of_appendix_a_and_what_the_1811_has_more_is_all_from_appendix_e():
    appendix_a = {int(opcode, 16) for opcode, _, where in ROWS if where == "A"}
    assert appendix_a <= {command.code for command in product("1810").commands}


def test_every_command_names_its_chapter():
    assert all(command.chapter and command.name for command in product("1811").commands)


def test_undefined_opcodes_are_ignored_without_a_trace(bench):
    board = ready(bench)
    for opcode in UNDEFINED:
        send_all(bench, board, (opcode,), (opcode, *range(1, 16)))
    assert message(bench, board) == b"" and board.bus.read(1) == 0x50
    assert board.axes["motor"].position == 0


@pytest.mark.parametrize("size", [0, 1, 15])
def test_any_opcode_is_survived_and_a_reset_makes_everything_as_it_was(bench, size):
    board = ready(bench)
    for opcode in range(0x100):
        send(bench, board, opcode, *(1,) * size, seconds=0.05)
        board.bus.write(1, RESET)
        bench.run(1.01)
        assert board.bus.read(1) == 0x50, f"{opcode:02X}h"
    assert ask(bench, board, 0x90)[:2] == b"\x90\x50"


@pytest.mark.parametrize(("opcode", "size"), [row for row in LISTED if row[1]])
def test_a_command_that_lacks_a_parameter_byte_is_ignored(bench, opcode, size):
    board = ready(bench)
    send(bench, board, opcode, *(1,) * (size - 1))
    assert message(bench, board) == b"" and board.bus.read(1) == 0x50


def test_surplus_bytes_must_be_zero(bench):
    """Chapter Command language syntax: `40 05` and `40 05 00 00 ...` are the same; other surplus bytes are invalid."""
    board = ready(bench)
    assert ask(bench, board, 0x01, 0x42)[:2] == b"\x01\x42"
    assert ask(bench, board, 0x01, 0x43, *(0,) * 14)[:2] == b"\x01\x43"
    assert ask(bench, board, 0x01, 0x44, 0, 1) == b"" and ask(bench, board, 0x90, 1) == b""


ACTS = st.one_of(
    st.tuples(st.just(0), st.integers(0, 255)),
    st.tuples(st.just(1), st.integers(0, 255)),
    st.tuples(st.just(2), st.sampled_from([c.code for c in product("1811").commands])),
    st.tuples(st.just(3), st.integers(0, 3000)),
)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(ACTS, max_size=60))
def test_any_bytes_on_either_register_at_any_time_neither_raise_nor_hang(acts):
    bench = Bench()
    board = bench.add("1811")
    bench.run(1.0)
    for what, value in acts:
        if what < 2:
            board.bus.write(what, value)
            board.bus.read(what)
        elif what == 2:
            for byte in (value, 1, 1, 1, 1):
                board.bus.write(0, byte)
            board.bus.write(1, 0x50)
        else:
            bench.run(value / 1000)
    bench.run(3)
    board.bus.write(1, RESET)
    bench.run(1.01)
    assert board.bus.read(1) == 0x50
