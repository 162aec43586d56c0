"""The text on the terminals of the page."""

import re

from axistwin import Bench, Session
from axistwin.bench import endpoints
from axistwin.ui.panel.talk import KEPT, Printer, Talk

COLOURS = re.compile(r"\x1b\[\d*m")


def bench_with(model, **options):
    bench = Bench()
    return bench, bench.add(model, **options), Talk(Session(lambda: bench))


def printed(bench, talk, name):
    printer = Printer(endpoints.codec_at(bench, name), endpoints.at_a_bus(bench, name))
    return COLOURS.sub("", printer.text(talk.since(name, 0)[1])).split("\r\n")[1:]


def test_a_serial_line_with_control_characters_in_words():
    bench, if1, talk = bench_with("if1")
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.1)
    assert [line[12:] for line in printed(bench, talk, "if1")] == [" > (", " < U<CR>"]
    assert printed(bench, talk, "if1")[0].startswith("    1.500000")


def test_carriage_return_ends_a_line_and_line_feed_belongs_to_it():
    bench, motor, talk = bench_with("smartmotor")
    bench.run(1.0)
    motor.serial.write(b"a=1 Ra Ra ")
    bench.run(0.2)
    assert [line[13:] for line in printed(bench, talk, "smartmotor")] == ["> a=1 Ra Ra ", "< 1<CR>", "< 1<CR>"]


def test_a_break_of_the_host_is_a_word():
    bench, if1, talk = bench_with("if1")
    bench.run(1.5)
    if1.serial.send_break(0.25)
    bench.run(1.0)
    assert printed(bench, talk, "if1")[0].endswith("> <BREAK 0.25 s>")


def test_opcodes_of_a_board_in_words():
    bench, board, talk = bench_with("1811")
    bench.run(1.0)
    for byte in (0xD9, 0x01):
        board.bus.write(0, byte)
    board.bus.write(1, 0x10)
    bench.run(0.1)
    (line,) = printed(bench, talk, "1811")
    assert "> D9 01   " in line and len(line.partition("D9 01   ")[2]) > 5


def test_a_terminal_is_told_what_it_has_not_seen_and_memory_is_bounded():
    bench, if1, talk = bench_with("if1", line="instant")
    bench.run(1.5)
    seen, _ = talk.since("if1", 0)
    if1.serial.write(b"(")
    bench.run(0.1)
    total, new = talk.since("if1", seen)
    assert total == seen + len(new) and b"".join(said.data for said in new) == b"(U\r"
    assert talk.since("if1", total) == (total, [])
    for _ in range(2 * KEPT):
        talk._take(new[0])
    assert len(talk._said["if1"]) == KEPT


def test_another_bench_begins_anew():
    bench, if1, talk = bench_with("if1")
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.1)
    before, other = talk.generation, Bench()
    other.add("if1")
    talk._attach(other)
    if1.serial.write(b"(")
    bench.run(0.1)
    assert talk.generation == before + 1 and talk.since("if1", 0) == (0, [])
