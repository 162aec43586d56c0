"""`axistwin probe`: verdicts, motion, options that explain a difference; controllers of a bench, in virtual time."""

import json
from dataclasses import replace

import pytest

from axistwin import Bench
from axistwin.bench import product
from axistwin.core.errors import LinkError, UsageError
from axistwin.real.hosts.real_time import open_end
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Motion, Settings, Verdict, probe
from axistwin.real.probing.report import html
from axistwin.sim.frames import UartFormat
from axistwin.testing import serve

from ..command import run
from ..told import raises

SMALL = Settings(Motion.SMALL)
CASES = {"if1": 151, "if2": 151, "1810": 156, "1811": 156, "smartmotor": 218}


def controller(model, **options):
    bench = Bench()
    made = bench.add(model, **options)
    bench.run(2)
    end = VirtualEnd(bench, made)
    if model == "if2":
        end.ask(b"(")
        end.ask(b"U61\r", wait_s=1.5)
    return made, end


def faulty(end, change):
    """Let the controller give wrong answers: `change(request, answer)` returns those of the faulty one."""
    send, receive, said = end.send, end.receive, [b""]

    def sending(data):
        said[0] = data
        send(data)

    end.send, end.receive = sending, lambda silence_s=0.0: change(said[0], receive(silence_s))
    return end


def interface(message, *said, baud=9600):
    """Return the host's end of an IF1 with a data format, and its line format."""
    parities = {"1": "N", "2": "N", "3": "O", "4": "E", "5": "O", "6": "E"}
    made, end = controller("if1")
    end.set_line(UartFormat(baud, 8, "N", 2))
    made.serial.write(b"(")
    end.bench.run(1.5)
    made.serial.write(message + (b"\r" if message[:1] == b"U" else b"\n"))
    end.bench.run(2.5)
    x1, x2 = message.decode()[1:]
    line = UartFormat(baud, 7 if x1 in "12" else 8, parities[x2], 1 if x1 in "1357" else 2)
    end.set_line(line)
    for text in said:
        made.serial.write(text)
        end.bench.run(2)
    return end, line


def differences(found):
    return [result.case.name for result in found.of(Verdict.DIFFERS)]


@pytest.mark.parametrize(("model", "cases"), CASES.items())
def test_an_unchanged_controller_is_the_same_and_nothing_moves(model, cases):
    made, end = controller(model)
    found = probe(model, end)
    assert len(found.of(Verdict.SAME)) == len(found.results) == cases and found.times_judged
    assert all(not result.case.moves and result.case.section for result in found.results)
    assert all(not axis.moving and axis.position == 0 for axis in made.axes.values())


@pytest.mark.parametrize("message", [b"V61", b"U62", b"V62", b"U31", b"V84", b"U23", b"V16"])
@pytest.mark.parametrize("settings", [Settings(find_options=False), Settings(Motion.SMALL, find_options=False)])
def test_every_data_format_of_an_if1_is_recognised(message, settings):
    end, line = interface(message)
    found = probe("if1", end, replace(settings, line=line))
    assert len(found.of(Verdict.SAME)) == len(found.results) >= CASES["if1"]


@pytest.mark.parametrize("message", [b"U61", b"V62"])
def test_a_slow_line(message):
    end, line = interface(message, baud=110)
    found = probe("if1", end, Settings(Motion.SMALL, line=line, find_options=False))
    assert len(found.of(Verdict.SAME)) == len(found.results)


def test_the_state_in_which_a_host_has_left_an_if1_is_no_difference():
    # A sequence of two steps, 30 steps and a backlash: O is 2, N is 30 by the sections on both requests.
    end, line = interface(b"U61", b"B+5\r", b":P0,1:P0,1:$\r", b"<2>2@300^3 X30$\r")
    found = probe("if1", end, Settings(Motion.SMALL, line=line, find_options=False))
    assert differences(found) == []
    depends = {result.case.name: result.received[0].data for result in found.of(Verdict.INCONCLUSIVE)}
    assert depends["O: sequence status"] == b"2\r" and depends["N: number of steps run or indexed"] == b"30\r"


@pytest.mark.parametrize(("model", "words"), [
    ("smartmotor", b"A=900 KP=50 SLE MV ECHO\r"), ("smartmotor", b"SLE a=9 MD G\r"), ("if1", b"(:U61\r:[\r")
])  # fmt: skip
def test_settings_of_a_host_are_no_differences(model, words):
    _, end = controller(model)
    for message in words.split(b":"):
        end.ask(message, wait_s=1.5)
    assert differences(probe(model, end, Settings(find_options=False))) == []


def number(request, answer):
    return lambda said, got: answer(got) if said.strip() == request else got


@pytest.mark.parametrize(("change", "name"), [
    (number(b"E", lambda got: got.replace(b"F", b"C")), "a data fault in the busy status and in the motion status"),
    (number(b"I", lambda got: got.replace(b"2", b"02")), "I: input status"),
    (number(b"I", lambda got: got.replace(b"2", b"3")), "I: input status"),
    (number(b"O", lambda got: got.replace(b"0", b"1")), "O: sequence status")])  # fmt: skip
def test_answers_that_no_machine_explains_differ(change, name):
    _, end = controller("if1")
    assert name in differences(probe("if1", faulty(end, change), Settings(find_options=False)))


def test_a_position_that_changes_without_motion_differs():
    """`X+1` without `$` only stores a distance: N stays as it was, whatever it was."""
    end, line = interface(b"U61", b"X30$\r")
    moved = []

    def change(said, got):
        moved.extend([said] * (said == b"X+1\r"))
        return got.replace(b"3", b"%d" % (2 + len(moved))) if said == b"N\r" and moved else got  # 30, then 40

    found = probe("if1", faulty(end, change), Settings(line=line, find_options=False))
    assert "X+1 without $, and N" in differences(found)
    end, line = interface(b"U61", b"X30$\r")
    assert differences(probe("if1", end, Settings(line=line, find_options=False))) == []


@pytest.mark.slow
def test_a_report_that_a_smartmotor_cannot_give_differs():
    _, end = controller("smartmotor")
    wrong = {b"RP\r": b"00", b"RBd\r": b"2"}
    found = probe("smartmotor", faulty(end, lambda said, got: got.replace(b"0", wrong.get(said, b"0"))))
    assert {"RP: report position", "RBd: report flag Bd"} <= set(differences(found))


@pytest.mark.parametrize(("model", "error"), [
    ("if1",
     r"the interface answers request E with b'\\x.*: expected C, E, F or \[ and CR; check --model and the line"),
    ("smartmotor", r"the motor answers RSP with b'g.*: expected e\.g\. 24576/476 and CR; check --model and the line"),
    ("1811", r"the board answers request 90h with c5 05.*: expected 90 and 15 more bytes; check --model")])  # fmt: skip
def test_garbage_is_quoted(model, error):
    _, end = controller(model)
    garbled = faulty(end, lambda said, got: bytes(byte ^ 0x55 for byte in got))
    with pytest.raises(LinkError, match=error):
        probe(model, garbled)


@pytest.mark.parametrize("model", ["if1", "1811"])
def test_small_motion_makes_pulses(model):
    made, end = controller(model)
    found = probe(model, end, SMALL)
    assert len(found.of(Verdict.SAME)) == len(found.results) > CASES[model]
    assert sum(axis.pulse_times().size for axis in made.axes.values())


@pytest.mark.slow
@pytest.mark.parametrize(("model", "option", "value", "text", "settings"), [
    ("if1", "busy", "ignore", 'busy="ignore"', SMALL),
    ("1811", "part_number", "94-012345-02B", 'part_number="94-012345-02B"', SMALL)])  # fmt: skip
def test_an_option_that_explains_the_differences(model, option, value, text, settings):
    _, end = controller(model, **{option: value})
    found = probe(model, end, settings)
    assert found.of(Verdict.DIFFERS) and text in found.fits


def test_the_test_plug_shows_the_outputs_of_an_if1():
    made, end = controller("if1")
    dialect(product("if1")).equip(made, {"plug": "True"})
    found = probe("if1", end, Settings(Motion.SMALL, plug=True, find_options=False))
    assert not differences(found)
    (outputs,) = [result for result in found.results if result.case.name == "S: set output high, with the test plug"]
    # outputs 1, 2 and 5; bits 8, 64 and 128 of the input status are set while inputs 1, 2 and 3 are low
    assert [answer.data for answer in outputs.received[1:10:2]] == [b"200\r", b"192\r", b"0\r", b"64\r", b"200\r"]
    _, end = controller("if1")
    assert len(differences(probe("if1", end, Settings(Motion.SMALL, plug=True, find_options=False)))) == 5


def test_late_answers_differ():
    _, end = controller("1811", reply_ms=8.0)
    found = probe("1811", end, Settings(find_options=False))
    assert {result.reason for result in found.of(Verdict.DIFFERS)} == {"the answer takes 0.0090 s instead of 0.0050 s"}


def test_values_of_the_machine_are_inconclusive_and_compared_only_as_new():
    made, end = controller("if1")
    made.pins["input1"].drive(True)
    found = probe("if1", end)
    assert not differences(found)
    assert [r.case.name for r in found.of(Verdict.INCONCLUSIVE)] == [
        "I: input status", "I with spaces", "I after an empty message",
    ]  # fmt: skip
    made, end = controller("if1")
    made.pins["input1"].drive(True)
    assert differences(probe("if1", end, Settings(as_new=True))) == [
        "I: input status", "I with spaces", "I after an empty message",
    ]  # fmt: skip


def test_a_busy_controller_is_only_read():
    made, end = controller("if1")
    end.ask(b"(")
    end.ask(b"U61\r", wait_s=1.5)
    end.ask(b":H1:X+1000:$\r")  # this sequence waits for input 1
    found = probe("if1", end, SMALL)
    skipped = found.of(Verdict.INCONCLUSIVE)
    assert {result.reason for result in skipped} >= {"a sequence is running or waiting: end it"}
    assert not any(result.received for result in found.results if result.case.writes or result.case.moves)
    assert made.axes["X"].position == 0


def test_a_message_that_another_host_has_not_ended_does_not_start():
    made, end = controller("if1")
    end.ask(b"(")
    end.ask(b"U61\r", wait_s=1.5)
    end.ask(b"X+1000$")
    assert not differences(probe("if1", end)) and made.axes["X"].position == 0


def test_a_stored_program_forbids_settings():
    _, end = controller("smartmotor")
    end.ask(b"UCI UDI ZS\r")
    end.ask(b"LOAD ", 1)
    end.ask(b"a=1 END \xff\xff", 1)
    assert (
        dialect(product("smartmotor")).examine(end, product("smartmotor")).no_writes.startswith("a program is stored")
    )


@pytest.mark.parametrize(("model", "said", "error"), [
    ("if1", b"(:U61\r:X+G$\r", "the motor is moving: stop the motor, then run axistwin probe again"),
    ("1811", b"\xd9\x0f", "the board does not answer request 90h: a sequence definition may still be open")
])  # fmt: skip
def test_a_controller_that_cannot_be_probed(model, said, error):
    _, end = controller(model)
    for message in said.split(b":"):
        end.ask(message, wait_s=1.5)
    with pytest.raises(LinkError, match=error.replace("(", r"\(").replace(")", r"\)")):
        probe(model, end)


def test_an_if2_that_waits_for_its_data_format_is_not_initialised():
    bench = Bench()
    end = VirtualEnd(bench, bench.add("if2"))
    bench.run(2)
    raises(LinkError, "the IF2 has no data format yet", probe, "if2", end)


def test_a_command_that_another_host_has_not_ended_does_not_start():
    made, end = controller("smartmotor")
    end.ask(b"UCI UDI ZS A=100 V=100000 P=5000 \rG")
    probe("smartmotor", end, Settings(find_options=False))
    assert not made.axes["shaft"].moving and made.axes["shaft"].position == 0


def test_a_silent_port():
    _, end = controller("if1", wiring="3-wire unlinked")
    began_s = end.now
    raises(LinkError, "does not answer request E", probe, "if1", end)
    assert end.now - began_s < 15


@pytest.mark.slow
@pytest.mark.parametrize(("model", "scheme"), [("if1", "pty"), ("smartmotor", "tcp"), ("1811", None)])
def test_a_real_port(model, scheme):
    made = product(model)
    with serve(model, scheme=scheme) as twin:
        end = open_end(str(twin.ports[model]), made.line)
        try:
            if scheme == "tcp":
                assert end.ask(b"RSP\r", 10).data == b"24576/476\r"
            elif scheme is None:
                end.ask(b"\x01\x07", 16)  # during the board's initialisation
                assert end.ask(b"\x01\x08", 16).data.endswith(b"\x01\x08" + bytes(14))
            else:
                while end.ask(b"(", 2).data != b"U\r":
                    pass
        finally:
            end.close()


def test_wrong_ports():
    raises(UsageError, "is not a bus socket: expected a bus socket for this board", open_end, "/dev/ttyUSB0", None)
    with pytest.raises(UsageError, match="is a register bus, not a serial port: expected a device"):
        open_end("bus://127.0.0.1:1", product("if1").line)
    with pytest.raises(LinkError, match=r"cannot open bus://127\.0\.0\.1:1 \(.*check the address"):
        open_end("bus://127.0.0.1:1", None)
    done = run("probe", "/dev/no-such-port", "--model", "if1")
    assert done.code == 2 and done.err.startswith("axistwin: cannot open /dev/no-such-port (")
    assert "Errno" not in done.err
    assert run("probe", "/dev/no-such-port", "--model", "if1", "--report", "x.txt").code == 2


def test_the_report():
    _, end = controller("1811", part_number="94-012345-02B")
    found = probe("1811", end)
    kept = json.loads(json.dumps(found.as_dict()))
    assert kept["counts"] == {"same": 154, "differs": 2, "inconclusive": 0}
    assert kept["facts"] == {"part number": "94-012345-02B"} and kept["seen_on_real_hardware"]["Requests"] > 50
    assert "<td>FDh part number</td>" in html(found) and html(found).count("<tr") == 157


def test_help_has_examples():
    assert "axistwin probe bus://127.0.0.1:1811 --model 1811" in run("probe", "--help").out
