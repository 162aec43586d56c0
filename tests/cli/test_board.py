"""The commands for a board on a bus: run, recordings, traces, plots, term, commands."""

import json

from axistwin import Bench
from axistwin.bench import Hear, host_of
from axistwin.bench.talk.conversation import parse, write
from axistwin.bench.talk.player import play
from axistwin.bench.talk.recorder import recording

from ..command import run

TALK = """\
; model: 1811
+1.1
> 31 00 00 00 00 61 A8 00 03 D0 90
> go_relative 25000         ; by its name
+2
= motor.position 25000
> 83
< 83 00 00 00 00 61 A8
= clock 3.105
! home low
> home_switch
< 8A
> 01 07
< 01 07
= interrupt low
"""

PROGRAM = """\
default_velocity_and_acceleration 00 25000 250000
go_relative 25000
83              ; when the move is over
32 00           ; continuous
+0.5
! cw_limit high
"""


def bench_with_a_board():
    bench = Bench()
    return bench, bench.add("1811")


def test_a_conversation():
    bench, _ = bench_with_a_board()
    assert play(parse(TALK), bench) is None


def test_a_message_is_filled_up_with_zeros():
    assert parse(TALK).acts[7] == Hear(bytes.fromhex("83 00 00 00 00 61 A8").ljust(16, b"\0"))


def test_what_is_different_is_shown_in_hex():
    bench, _ = bench_with_a_board()
    difference = play(parse("; model: 1811\n+1.1\n> 01 07\n< 01 08\n"), bench)
    assert difference.expected.startswith("01 08 00") and difference.got.startswith("01 07 00")


def test_a_conversation_that_does_not_say_its_model(tmp_path):
    talk = tmp_path / "a.talk"
    talk.write_text(TALK.partition("\n")[2])
    assert run("run", "1811", talk)[0] == 0


def test_a_recording_is_played_again_to_the_nanosecond():
    bench, board = bench_with_a_board()
    with recording(bench) as recorder, host_of(board) as host:
        host.subscribe_received(lambda message: None)
        bench.run(1.1)
        for command in ("31 00 00 00 00 61 A8 00 03 D0 90", "33 00 00 61 A8", "83", "01 07"):
            host.write(bytes.fromhex(command))
            bench.run(0.7)
        board.pins["home"].drive(False)
        bench.run(1)
    text = write(recorder.conversation())
    assert "> 33 00 00 61 A8\n" in text and "= motor.position 25000" in text
    again, _ = bench_with_a_board()
    assert play(parse(text), again) is None and again.now == bench.now


def test_a_program(tmp_path):
    program, trace, plot = tmp_path / "p.181x", tmp_path / "t.csv", tmp_path / "p.svg"
    program.write_text(PROGRAM)
    code, told, _ = run("run", "1811", program, "--trace", trace, "--plot", plot)
    assert code == 0 and "> 33 00 00 61 A8   go relative: distance 25000 pulses" in told
    assert "< 83 00 00 00 00 61 A8   position from absolute zero: position 25000 pulses" in told
    assert "! cw_limit high" in told
    rows = trace.read_text().splitlines()
    assert any(row.endswith("1811.host_says,33 00 00 61 A8") for row in rows)
    assert any(row.endswith("1811.motor.pulses,25000") for row in rows)
    assert plot.read_text().startswith("<?xml")


def test_a_program_as_json(tmp_path):
    program = tmp_path / "p.181x"
    program.write_text(PROGRAM)
    _, told, _ = run("run", "1810", program, "--json")
    said = json.loads(told)["said"]
    assert [one["text"][:8] for one in said] == ["31 00 00", "33 00 00", "83", "83 00 00", "32 00"]
    assert said[3]["words"] == "position from absolute zero: position 25000 pulses"


def test_a_program_that_cannot_be_read(tmp_path):
    program = tmp_path / "p.181x"
    program.write_text("70\ngo_relative x\n")
    code, _, told = run("run", "1811", program)
    assert code == 1 and f"{program}:2:13: invalid distance 'x'" in told


def test_a_program_for_something_else(tmp_path):
    program = tmp_path / "p.181x"
    program.write_text("70\n")
    assert run("run", "if1", program)[0] == 1


def test_a_terminal():
    lines = "default_velocity_and_acceleration 00 25000 250000\ngo_relative 25000\n83\nbogus\n\n:axes\n"
    code, told, _ = run("term", "1811", "--speed", "max", typed=lines)
    assert code == 0
    assert "< 83 00 00 00 00 61 A8   position from absolute zero: position 25000 pulses" in told
    assert "no command 'bogus'" in told and "motor  25000  at rest" in told


def test_commands():
    code, told, _ = run("commands", "1811")
    assert code == 0 and "go relative" in told
