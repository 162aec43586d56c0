"""`axistwin rescue`: contents of each family, line formats, twins, ports, and controllers that cannot be read."""

import json
import tomllib

import pytest

from axistwin import Bench, Scene
from axistwin.bench import action, product
from axistwin.bench.programs import stored_programs
from axistwin.bench.talk.conversation import parse
from axistwin.bench.talk.player import play
from axistwin.core.errors import LinkError, UsageError
from axistwin.real.hosts.real_time import open_end
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.rescue.finding import Found, find
from axistwin.real.probing.rescue.saving import rescue
from axistwin.sim.frames import UartFormat
from axistwin.testing import serve

from ..command import run
from ..told import raises

BOARD = (
    "31 00 00 00 00 03 E8 00 00 27 10", "C8 02 00 00 00 03 E8 00 00 27 10 00 00 00 32",
    "CE 03 00 00 00 03 E8 00 00 27 10 01", "D9 03", "40 02", "29 00 00 07 D0", "D8", "2E FF FF FF 00", "08 05", "0C 01",
    "B0 00 02 00 01", "B3 01 05 00 00 00 10 00",
)  # fmt: skip
SETUP = """08 05
0D 04
B0 00 02 00 01
B3 01 05 00 00 00 10 00
31 00 00 00 00 03 E8 00 00 27 10
C8 02 00 00 00 03 E8 00 00 27 10 00 00 00 32
CE 03 00 00 00 03 E8 00 00 27 10 01
D9 03
40 02
29 00 00 07 D0
D8
2E FF FF FF 00
"""
PROGRAM = "C1\na=a+1\nRETURN\nEND\n"


def controller(model, **options):
    bench = Bench()
    made = bench.add(model, **options)
    return made, VirtualEnd(bench, made)


def interface(message, line):
    made, end = controller("if1")
    end.bench.run(1.5)
    end.set_line(UartFormat(line.baudrate, 8, "N", 2))
    made.serial.write(b"(")
    end.bench.run(1)
    made.serial.write(message)
    end.bench.run(2)
    end.set_line(line)
    return made, end


def motor(*commands, program=PROGRAM):
    made, end = controller("smartmotor")
    if program:
        stored_programs.store(program.encode(), "program.sms", made)
    for said in commands:
        end.ask(said)
    return made, end


def board():
    made, end = controller("1811")
    end.bench.run(1.5)
    for command in BOARD:
        end.ask(bytes.fromhex(command))
    return made, end


def again(directory):
    bench = Scene.load(directory / "machine.toml").build()
    (made,) = bench.controllers.values()
    return bench, VirtualEnd(bench, made)


def table(done):
    return tomllib.loads(done.files["machine.toml"])["controller"][0]


def test_a_motor_and_its_twins(tmp_path):
    made, end = motor(b"UCI UDI ZS a=7 zzz=-4 ab[4]=9 KP=99 F SLP=500 E=2000 D=5 P=100 O=33 \r")
    action(made, "E", "low")()
    first = rescue(end, find(end), tmp_path / "first")
    assert not first.differences and (tmp_path / "first/program.sms").read_text() == PROGRAM
    assert table(first)["variables"] == {
        "KP": 99, "E": 2000, "SLP": 500, "a": 7, "bb": 9 << 24, "zzz": -4, "O": 33, "D": 5, "P": 100,
    }  # fmt: skip
    values = json.loads((tmp_path / "first/rescue.json").read_text())["values"]
    assert values["RSP"] == "24576/476" and values["RU"] == "111"
    bench, end = again(tmp_path / "first")
    second = rescue(end, find(end), tmp_path / "second")
    assert {n: second.files[n] for n in ("machine.toml", "program.sms")} == {
        n: first.files[n] for n in ("machine.toml", "program.sms")
    }
    _, end = again(tmp_path / "second")
    assert rescue(end, find(end), tmp_path / "third").files == second.files
    assert made.axes["shaft"].position == bench["smartmotor"].axes["shaft"].position == 0


def test_separate_arrays_are_found(tmp_path):
    _, end = controller("smartmotor", array_overlay=False)
    end.ask(b"al[3]=70000 aa=1 \r")
    done = rescue(end, Found("smartmotor"), tmp_path / "out")
    assert not done.differences and table(done)["options"] == {"array_overlay": False}
    assert table(done)["variables"] == {"aa": 1, "al[3]": 70000}


def test_a_locked_program_and_an_echo(tmp_path):
    _, end = motor(b"LOCKP ZS ECHO\r")
    done = rescue(end, Found("smartmotor"), tmp_path / "out")
    assert done.contents.program == ""
    assert "program: UPLOAD is not answered; the program is locked by LOCKP" in done.contents.missing
    assert end.ask(b"RBs\r", 6).data.endswith(b"RBs\r0\r")  # the flag that UPLOAD has set is cleared
    assert set(done.differences) == {"RCKS"}


def test_a_board_and_its_twins(tmp_path):
    _, end = board()
    first = rescue(end, find(end), tmp_path / "first")
    assert not first.differences and first.files["setup.181x"] == SETUP
    assert first.contents.values["sequence 3"] == "40 02 / 29 00 00 07 D0"
    bench, end = again(tmp_path / "first")
    bench.run(3)
    assert rescue(end, find(end), tmp_path / "second").files == first.files
    assert not any(axis.pulse_times().size for axis in bench["1811"].axes.values())


def test_a_streaming_mode_is_restored(tmp_path):
    _, end = controller("1811")
    end.bench.run(1.5)
    end.ask(bytes.fromhex("52 01 02 00 00 00 10 00 05"))
    done = rescue(end, find(end), tmp_path / "out")
    assert done.files["setup.181x"] == "52 01 02 00 00 00 10 00 05\n" and not done.differences


@pytest.mark.parametrize(("message", "line"), [
    (b"U61\r", UartFormat(9600, 8, "N", 2)), (b"V26\n", UartFormat(1200, 7, "E", 2)),
    (b"U13\r", UartFormat(110, 7, "O", 2))])  # fmt: skip
def test_an_interface_is_found_with_an_incomplete_move(tmp_path, message, line):
    made, end = interface(message, line)
    made.pins["input1"].drive(True)
    made.serial.write(b"X+100$")
    end.bench.run(1)
    found = find(end)
    assert found == Found("if1", line)
    done = rescue(end, found, tmp_path / "out")
    assert not done.differences and done.contents.values["format"][0] == message.decode()[0]
    assert 'do = ["input1 high"]' in done.files["machine.toml"]
    assert "# Not read: sequence: no request lists it" in done.files["machine.toml"]
    assert not any(axis.pulse_times().size for axis in made.axes.values())


@pytest.mark.parametrize("rate", [2400, 38400])
def test_a_motor_is_found_with_an_incomplete_move(rate):
    made, end = motor(b"UCI UDI ZS A=100 V=100000 P=5000 \r", b"BAUD%d\r" % rate, program="")
    end.set_line(UartFormat(rate))
    made.serial.write(b"G")
    end.bench.run(0.1)
    assert find(end) == Found("smartmotor", UartFormat(rate))
    assert not made.axes["shaft"].moving and made.registers["P"].read() == 5000


def test_the_exchange_is_a_conversation_with_the_twin(tmp_path):
    _, end = board()
    rescue(end, find(end), tmp_path / "out")
    bench, end = again(tmp_path / "out")
    end.close()
    bench.run(3)
    play(parse((tmp_path / "out/exchange.talk").read_text()), bench)


@pytest.mark.parametrize(("made", "error"), [
    (lambda: controller("if1", wiring="3-wire unlinked"), "or in any character format: check cable"),
    (lambda: motor(b"SLEEP\r"), "or in any character format: check cable"),
    (lambda: motor(b"UCI UDI ZS MV A=100 V=1000 G\r"), "the motor is moving: stop the motor")])  # fmt: skip
def test_a_controller_that_cannot_be_read(tmp_path, made, error):
    _, end = made()
    end.bench.run(2)
    with pytest.raises(LinkError, match=error):
        rescue(end, find(end, end.controller.product.model), tmp_path / "out")
    assert not (tmp_path / "out/machine.toml").exists()


def test_an_interface_without_data_format_is_not_initialised(tmp_path):
    _, end = controller("if2")
    end.bench.run(2)
    raises(LinkError, "has no data format yet", find, end)


def test_an_open_sequence_is_not_extended(tmp_path):
    _, end = controller("1811")
    end.bench.run(1.5)
    end.ask(b"\xd9\x03")
    with pytest.raises(LinkError, match="does not answer request 90h: a sequence definition may still be open"):
        rescue(end, Found("1811"), tmp_path / "out")
    end.ask(b"\xd8")
    assert end.ask(b"\x92\x03", 16).data == b"\x92" + bytes(15)


def test_what_was_received_is_kept_when_the_port_is_lost(tmp_path):
    _, end = motor()
    receive, left = end.receive, iter(range(400))

    def failing():
        if next(left, None) is None:
            raise LinkError("/dev/ttyUSB0 was disconnected")
        return receive()

    end.receive = failing
    with pytest.raises(
        LinkError, match=r"was disconnected; the data received before this error are in .*exchange\.talk"
    ):
        rescue(end, Found("smartmotor"), tmp_path / "out")
    assert "> RKP\\r\n< " in (tmp_path / "out/exchange.talk").read_text()
    assert not (tmp_path / "out/machine.toml").exists()


@pytest.mark.parametrize(("last", "unanswered"), [(b"RKP\r", 4), (b"Ral[3]\r", 4), (b"UPLOAD\r", 2)])
def test_a_controller_that_falls_silent_is_left_after_three_requests_and_a_check(tmp_path, last, unanswered):
    """A program that is not reported may be locked by LOCKP, so UPLOAD is followed by the check at once."""
    _, end = motor()
    send, said, progress = end.send, [], []

    def sending(data):
        said.append(data)
        if last not in said:
            send(data)

    end.send = sending
    with pytest.raises(LinkError, match=r"no longer answers, after \d+ answers: check its power and the cable"):
        rescue(end, Found("smartmotor"), tmp_path / "out", lambda *counts: progress.append(counts))
    assert len(said) - said.index(last) == progress[-1][1] == unanswered
    assert (tmp_path / "out/exchange.talk").exists()


@pytest.mark.parametrize(("made", "error"), [
    (motor, r"the controller answers with b'e.*' at 9600 8N1: expected an answer of a SmartMotor, IF1 or IF2"),
    (lambda: interface(b"U61\r", UartFormat(9600, 8, "N", 2)), r"the controller answers with b'.*' at 9600 8N"),
    (board, r"the board answers request 90h with c5 05.*: expected 90 and 15 more bytes")])  # fmt: skip
def test_garbage_is_quoted(tmp_path, made, error):
    _, end = made()
    receive = end.receive
    end.receive = lambda: bytes(byte ^ 0x55 for byte in receive())
    with pytest.raises(LinkError, match=error):
        rescue(end, find(end), tmp_path / "out")


def test_reports_that_a_motor_does_not_know_are_no_silence(tmp_path):
    _, end = motor()
    send = end.send
    unknown = (b"RKV\r", b"RKA\r", b"RKG\r", b"PRINT(A,#13)\r", b"PRINT(V,#13)\r")
    end.send = lambda data: None if data in unknown else send(data)
    done = rescue(end, Found("smartmotor"), tmp_path / "out")
    assert "no answer to KV, KA, KG, A, V" in done.contents.missing


def test_a_directory_that_is_not_empty(tmp_path):
    (tmp_path / "file").write_text("")
    done = run("rescue", "/dev/no-such-port", "--out", str(tmp_path))
    assert (done.code, done.err) == (2, f"axistwin: {tmp_path} exists already: choose another directory\n")
    raises(UsageError, "exists already", rescue, controller("1811")[1], Found("1811"), tmp_path)
    assert run("rescue", "/dev/no-such-port", "--out", str(tmp_path / "new")).code == 2


@pytest.mark.slow
@pytest.mark.parametrize(("model", "scheme"), [("smartmotor", "pty"), ("if1", "tcp"), ("1811", None)])
def test_a_real_port(model, scheme, tmp_path):
    with serve(model, scheme=scheme, speed="max") as twin:
        if model == "if1":
            end = open_end(str(twin.ports[model]), product(model).line)
            while end.ask(b"(", 2).data != b"U\r":
                pass
            end.ask(b"U61\r")
            assert end.ask(b"E\r", 2).data == b"C\r"
            end.close()
        if model == "1811":
            end = open_end(str(twin.ports[model]), None)
            end.ask(b"\x01\x07", 16)
            end.close()
        done = run("rescue", str(twin.ports[model]), "--out", str(tmp_path / "out"))
    assert done.code == 0, done.err
    assert "gives the same answers" in done.out
    assert ("no setup.181x: " in done.out) is (model == "1811" and not (tmp_path / "out/setup.181x").exists())
    assert (tmp_path / "out/machine.toml").exists()


def test_a_board_without_contents_has_no_setup_and_the_user_is_told(tmp_path):
    with serve("1811", speed="max") as twin:
        done = run("rescue", str(twin.ports["1811"]), "--out", str(tmp_path / "out"))
    assert done.code == 0, done.err
    assert "no setup.181x: the board contains nothing" in done.out
    assert not (tmp_path / "out/setup.181x").exists()


def test_help_has_examples():
    assert "axistwin rescue bus://127.0.0.1:1811 --out winder" in run("rescue", "--help").out
