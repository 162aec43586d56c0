"""Section 15 of the base language, and 2.0 item 6: loading, keeping and uploading the program."""

import json

import pytest

from axistwin import Bench
from axistwin.controllers.smartmotor.language import program
from axistwin.controllers.smartmotor.language.language import Statement, read
from axistwin.core.errors import UsageError
from axistwin.core.units import S

from .scripts import play, scripts
from .talking import END, ask, bare, clear, load, ready, send, upload

COUNTING = "a=1 'counts\nWHILE a<5\n  a=a+1\nLOOP\nEND\n"
TEXT = b"a=1\nWHILE a<5\na=a+1\nLOOP\nEND\n"
IMAGE = b"$40000006D8" + b"00001D" + b"0000000000" + b"a=1\n$W0019LE a<5\na=a+1\n$L0004P\nEND\n"


@scripts({
    # Loading
    "15: the motor sends 06 after LOAD and after each complete block of 8 bytes; FF FF ends the program":
    "sends LOAD<SP> => <06>; sends a=1 b=2<SP> => <06>; sends c=3 EN; sends D; sends <FF><FF><SP>; RUN; 0.1 s; "
    "Ra Rb Rc RBk -> 1 2 3 0",
    "If FF is the last byte of a block, the motor sends 06 after 50 ms, or none if a second FF follows":
    "sends LOAD<SP> -> *; sends a=1<LF>END<FF>; 0.04 s; sends <FF>; 1 s; sends LOAD<SP> -> *; "
    # the sum of 61+3D+31+0A, and E1 for END
    "sends a=1<LF>END<FF> => <06> in 0.1 s; sends a note<FF><FF>; RCKS => 000000 0001BA P<CR>",
    "program bytes are neither commands nor addresses":
    "sends SADDR1 LOAD<SP> -> *; sends b=7 Rb<LF><CR><82><80>RP END<FF><FF> -> *; Rb -> 0; RUN -> 7 in 0.1 s",
    "2: during a download too, every received byte is echoed":
    "sends ECHO LOAD<SP> => LOAD <06>; sends a=1 END<LF><FF><FF> => a=1 END<LF><06><FF><FF>",
    # Refused downloads
    "2.0 items 1 and 6: with nothing wired the motor is in fault at power-up; LOAD then sets Bs and sends no "
    "06":
    "bare; LOAD; RBs RBr RBl -> 1 1 1; UCI UDI LOAD ZS LOAD => <06>",
    "a program cannot load":
    "load LOAD / UPLOAD / UP / a=1; RUN; 0.1 s; Ra RBs -> 1 1",
    # Incomplete downloads
    "Some hosts of class 4 motors send a single FF; followed by silence it ends the download":
    "sends LOAD<SP> -> *; sends a=1<LF><FF> -> *; 5.1 s; RBk RUN -> 0 in 0.1 s; Ra -> 1",
    "10: Bk is set at power-up, and no program starts":
    "load PRINT(1,#13); sends LOAD<SP> -> *; sends PRINT(2,#13) -> *; power cycle; 1 s; receives nothing; "
    "RBk RUN RCKS => 1<CR>000000 000000 F<CR> in 0.1 s",
    # Uploading
    "15: UPLOAD sends 8 bytes after each 06 from the host, and FF at the end":
    "load a=12345 / END; sends UPLOAD<SP> => a=12345<LF>; sends <06> => END<LF><FF>; RP -> 0",
    "a text of whole blocks is followed by the end alone":
    "load a=1 / END; sends UPLOAD<SP> => a=1<LF>END<LF>; sends <06> => <FF>",
    "the echo applies to an upload":
    "load a=12345 / END; sends ECHO UPLOAD<SP> => UPLOAD a=12345<LF>; sends <06> => <06>END<LF><FF>",
    # Checksums
    "a new motor has an empty program":
    "RCKS RBk RUN RBs => 000000 000000 P<CR>0<CR>0<CR> in 0.1 s",
    # Starting
    "2: the stored program starts if nothing is received in the first 200 ms":
    'load PRINT("up",#13) / END; power cycle; 0.199 s; receives nothing; 0.002 s; receives up<CR>',
    "8: RUN? ends a program that power-up has started; a program started by RUN skips it":
    'load PRINT("a") / RUN? / PRINT("b") / END; power cycle; 1 s; receives a; RUN => ab in 0.1 s',
    "z starts it as power up does":
    'load PRINT("up",#13) / END; Z; 0.19 s; 0.1 s; receives up<CR>',
    # Loading
    "a program of whole blocks ends without another answer":
    "load a=1 END / a=1 END",
    # Incomplete downloads
    "10: Bk is set, the program is not run, and RCKS reports F":
    f"load {COUNTING}; sends LOAD<SP> -> *; sends a=9 b=9<SP> => <06> in 4.9 s; sends c=9<SP>; 4.9 s; "
    "sends d=9 END<SP> => <06> in 5.1 s; RUN RBk RCKS => 1<CR>000000 * in 0.1 s; Ra Rb RCKS => * F<CR>; "
    f"ZS RCKS RBk => * F<CR>1<CR>; load {COUNTING}; RBk -> 0",
    # Checksums
    "RCKS reports the place of the labels and the sum":
    [f"load {program}; RCKS => {sums}<CR>"
     for program, sums in (
         ("END", "000000 0000E1 P"), ("  END 'nothing\r\n", "000000 0000E1 P"),  # the manual's example
         ("a=1 / C5 / END", "000004 00023C P"),  # C5 is at 4; the sum of 61+3D+31+0A, 43+35+0A, and E1
     )],
    # Starting
    "any character in the first 200 ms prevents it":
    [f'load PRINT("up",#13) / END; power cycle; 0.19 s; writes {traffic}; 1 s; receives nothing'
     for traffic in ("<CR>", "<85>", "RP")],
})  # fmt: skip
def test_program_store(script):
    play(script)


# Loading


def test_a_block_may_have_32_bytes(bench):
    """Option load_block=32: blocks of 32 bytes, as in later firmware."""
    load(bench, ready(bench, load_block=32), COUNTING, block=32)


@pytest.mark.parametrize("program", [COUNTING, IMAGE])
def test_source_and_image_make_the_same_program(bench, motor, program):
    load(bench, motor, program)
    assert upload(bench, motor) == TEXT and upload(bench, motor, "UP") == IMAGE
    assert send(bench, motor, "RUN", 0.1) == b"" and ask(bench, motor, "Ra") == "5"


def test_loading_stops_the_running_program(bench, motor):
    load(bench, motor, "WHILE 1\na=a+1\nLOOP\n")
    send(bench, motor, "RUN", 0.1)
    send(bench, motor, b"LOAD ")
    send(bench, motor, b"END" + END)
    before = ask(bench, motor, "Ra")
    bench.run(0.1)
    assert ask(bench, motor, "Ra") == before != "0"


# Incomplete downloads


def test_a_program_that_is_too_long_is_broken(bench):
    """Characters beyond option program_bytes are ignored, and the program is invalid."""
    motor = ready(bench, program_bytes=256)
    load(bench, motor, "a=1\n" * 64)
    send(bench, motor, b"LOAD ")
    send(bench, motor, b"a=1\n" * 64 + b"END" + END)
    assert send(bench, motor, "RBk RUN Ra", 0.1) == b"1\r0\r"


def test_a_damaged_image_is_broken(bench, motor):
    send(bench, motor, b"LOAD ")
    send(bench, motor, IMAGE.replace(b"a<5", b"a<6") + END)
    assert ask(bench, motor, "RBk") == "1"


def test_a_line_error_breaks_the_download(bench):
    motor = clear(bench, bench.add("smartmotor"))
    send(bench, motor, "OCHN(RS2,0,E,9600,1,8,C)", 0.1)
    motor.serial.host.parity = "E"
    send(bench, motor, b"LOAD ", 0.1)
    motor.serial.to_device.flip(1)
    send(bench, motor, b"a=1\nEND\n" + END, 0.1)
    assert send(bench, motor, "RBk RBb", 0.1) == b"1\r1\r"


# Uploading


def test_anything_else_than_06_ends_the_upload_and_is_heard(bench, motor):
    load(bench, motor, COUNTING)
    assert send(bench, motor, b"UPLOAD ") == TEXT[:8] and send(bench, motor, b"RP ") == b"0\r"


def test_a_locked_program_is_not_uploaded(bench, motor):
    """LOCKP prevents UPLOAD until another program is loaded."""
    load(bench, motor, COUNTING)
    assert send(bench, motor, "LOCKP UPLOAD UP RBs") == b"1\r"
    motor.power_cycle()
    clear(bench, motor)
    assert send(bench, motor, "UPLOAD RBs") == b"1\r" and ask(bench, motor, "Ra") == "0"
    load(bench, motor, COUNTING)
    assert upload(bench, motor) == TEXT


# Keeping


def test_the_program_is_kept_in_the_state_directory(bench, tmp_path):
    load(bench, ready(bench, state=tmp_path), COUNTING)
    other = Bench()
    assert upload(other, ready(other, state=tmp_path)) == TEXT
    assert json.loads((tmp_path / "smartmotor.json").read_text())["program"] == TEXT.decode()


def test_between_load_and_its_end_the_kept_program_is_not_valid(bench, tmp_path):
    """After a power cut at any time of a download, the stored program is either valid or marked as invalid."""
    motor = ready(bench, state=tmp_path)
    load(bench, motor, COUNTING)
    for part in (b"LOAD ", b"a=1\n", b"END\n", b"\xff"):
        send(bench, motor, part)
        assert json.loads((tmp_path / "smartmotor.json").read_text())["broken"] is True
    send(bench, motor, b"\xff")
    assert json.loads((tmp_path / "smartmotor.json").read_text()) == {
        "version": 1, "program": "a=1\nEND\n", "broken": False, "locked": False, "eeprom": "",
    }  # fmt: skip


@pytest.mark.parametrize("contents", [
    "", "no JSON", "[]", "null", '{"version": 2}', '{"version": 1}', "[" * 100_000,
    '{"version": 1, "program": 7, "broken": false, "locked": false, "eeprom": ""}',
    '{"version": 1, "program": "\\u20ac", "broken": false, "locked": false, "eeprom": ""}',
    '{"version": 1, "program": "", "broken": 0, "locked": false, "eeprom": ""}',
    '{"version": 1, "program": "", "broken": false, "locked": false, "eeprom": "xy"}',
    '{"version": 1, "program": "", "broken": false, "locked": false, "eeprom": 1}'])  # fmt: skip
def test_a_spoilt_state_file_is_told_with_its_name(bench, tmp_path, contents):
    (tmp_path / "smartmotor.json").write_text(contents)
    with pytest.raises(
        UsageError, match=r"smartmotor\.json is not a memory file of a SmartMotor \(.*\): delete the file"
    ):
        bench.add("smartmotor", state=tmp_path)


LONG = "".join(f"a=a+{number}\n" for number in range(3600))
"""A program that fills the memory of 32 KB."""


def _most_in_one_step(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> int:
    """Return the largest number of statements executed in one step of the clock."""
    count, most, quiet_ns = 0, 0, bench.now + S

    def counted(text: str) -> Statement:
        nonlocal count
        count += 1
        return read(text)

    monkeypatch.setattr(program, "read", counted)
    while (due := bench.clock.next_event_ns()) is not None and due < quiet_ns:
        before = count
        bench.clock.step()
        most = max(most, count - before)
    monkeypatch.undo()
    assert count >= 3600
    return most


def test_a_long_program_is_compiled_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    motor = bench.add("smartmotor")
    bench.run(0.5)
    motor.serial.write(b"UCI UDI ZS LOAD ")
    bench.run(0.1)
    assert motor.serial.read() == b"\x06"
    motor.serial.write(LONG.encode())
    bench.run(len(LONG) * 10 / 9600 + 0.01)
    motor.serial.write(b"\xff\xff")
    assert _most_in_one_step(bench, monkeypatch) == program.PIECE
    motor.serial.read()
    motor.serial.write(b"RUN RCKS\r")
    bench.run(0.1)
    assert motor.serial.read().endswith(b"P\r")


def test_a_long_program_is_compiled_in_pieces_when_the_power_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    motor = bare(bench)
    motor.serial.write(b"UCI UDI ZS LOAD " + LONG.encode() + b"\xff\xff")
    motor.power_cycle()
    assert _most_in_one_step(bench, monkeypatch) == program.PIECE


def test_a_program_that_is_not_compiled_yet_can_be_run_in_the_same_nanosecond() -> None:
    bench = Bench()
    motor = bare(bench)
    motor.serial.write(b"UCI UDI ZS LOAD C5 a=7 END\n" + LONG.encode() + b"\xff\xffGOSUB5 ")
    bench.run(0.1)
    motor.serial.read()
    motor.serial.write(b"Ra\r")
    bench.run(0.1)
    assert motor.serial.read() == b"7\r"


@pytest.mark.parametrize("text", [
    "SWITCH a\n" + "CASE 1\n" * 2000 + "ENDS\n", "IF a\n" + "ELSEIF a\n" * 2000 + "ENDIF\n",
    "WHILE 1\n" * 2000 + "BREAK\n" * 2000, "IF a\nELSE\n" + "ELSE\n" * 2000 + "ENDIF\n"])  # fmt: skip
def test_blocks_cost_the_same_for_each_of_their_parts(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    count, word = 0, program.word

    def counted(statement: Statement) -> str:
        nonlocal count
        count += 1
        return word(statement)

    monkeypatch.setattr(program, "word", counted)
    program.Program.compile(text)
    assert count < 8 * text.count("\n")
