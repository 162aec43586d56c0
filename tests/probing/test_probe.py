"""`axistwin probe`: verdicts, motion, options that explain a difference; controllers of a bench, in virtual time."""

import json

import pytest

from axistwin import Bench
from axistwin.bench import product
from axistwin.errors import LinkError, UsageError
from axistwin.probing import Motion, Settings, Verdict, VirtualEnd, dialect, html, open_end, probe
from axistwin.testing import serve

from ..command import run

SMALL = Settings(Motion.SMALL)
CASES = {"if1": 138, "if2": 138, "1810": 156, "1811": 156, "smartmotor": 218}


def controller(model, **options):
    bench = Bench()
    made = bench.add(model, **options)
    bench.run(2)
    end = VirtualEnd(bench, made)
    if model == "if2":
        end.ask(b"(")
        end.ask(b"U61\r", wait_s=1.5)
    return made, end


def differences(found):
    return [result.case.name for result in found.of(Verdict.DIFFERS)]


@pytest.mark.parametrize(("model", "cases"), CASES.items())
def test_an_unchanged_controller_is_the_same_and_nothing_moves(model, cases):
    made, end = controller(model)
    found = probe(model, end)
    assert len(found.of(Verdict.SAME)) == len(found.results) == cases
    assert found.times_judged
    assert all(not result.case.moves and result.case.section for result in found.results)
    assert all(not axis.moving and axis.position == 0 for axis in made.axes.values())


@pytest.mark.parametrize("model", ["if1", "1811"])
def test_small_motion_makes_pulses(model):
    made, end = controller(model)
    found = probe(model, end, SMALL)
    assert len(found.of(Verdict.SAME)) == len(found.results) > CASES[model]
    assert sum(axis.pulse_times().size for axis in made.axes.values())


@pytest.mark.parametrize(
    ("model", "option", "value", "text", "settings"),
    [
        ("if1", "busy", "ignore", 'busy="ignore"', SMALL),
        ("1811", "part_number", "94-012345-02B", 'part_number="94-012345-02B"', SMALL),
    ],
)
def test_an_option_that_explains_the_differences(model, option, value, text, settings):
    _, end = controller(model, **{option: value})
    found = probe(model, end, settings)
    assert found.of(Verdict.DIFFERS)
    assert text in found.fits


def test_the_test_plug_shows_the_outputs_of_an_if1():
    made, end = controller("if1")
    dialect(product("if1")).equip(made, {"plug": "True"})
    found = probe("if1", end, Settings(Motion.SMALL, plug=True, find_options=False))
    assert not differences(found)
    (outputs,) = [result for result in found.results if result.case.name == "S: set output high, with the test plug"]
    # outputs 1, 2 and 5; bits 8, 64 and 128 of the input status are set while inputs 1, 2 and 3 are low
    assert [answer.data for answer in outputs.received[1:10:2]] == [b"200\r", b"192\r", b"0\r", b"64\r", b"200\r"]
    _, end = controller("if1")
    missing = probe("if1", end, Settings(Motion.SMALL, plug=True, find_options=False))
    assert len(differences(missing)) == 5


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
    assert not differences(probe("if1", end))
    assert made.axes["X"].position == 0


def test_a_stored_program_forbids_settings():
    _, end = controller("smartmotor")
    end.ask(b"UCI UDI ZS\r")
    end.ask(b"LOAD ", 1)
    end.ask(b"a=1 END \xff\xff", 1)
    assert (
        dialect(product("smartmotor")).examine(end, product("smartmotor")).no_writes.startswith("a program is stored")
    )


@pytest.mark.parametrize(
    ("model", "said", "error"),
    [
        ("if1", b"(:U61\r:X+G$\r", "the motor is moving: stop the motor, then run axistwin probe again"),
        ("1811", b"\xd9\x0f", "the board does not answer request 90h (received nothing): a sequence definition may"),
    ],
)
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
    with pytest.raises(LinkError, match="the IF2 has no data format yet"):
        probe("if2", end)


def test_a_command_that_another_host_has_not_ended_does_not_start():
    made, end = controller("smartmotor")
    end.ask(b"UCI UDI ZS A=100 V=100000 P=5000 \rG")
    probe("smartmotor", end, Settings(find_options=False))
    assert not made.axes["shaft"].moving
    assert made.axes["shaft"].position == 0


def test_a_silent_port():
    _, end = controller("if1", wiring="3-wire unlinked")
    with pytest.raises(LinkError, match="does not answer request E"):
        probe("if1", end)


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
    with pytest.raises(UsageError, match="is not a bus socket: expected a bus socket for this board"):
        open_end("/dev/ttyUSB0", None)
    with pytest.raises(UsageError, match="is a register bus, not a serial port: expected a device"):
        open_end("bus://127.0.0.1:1", product("if1").line)
    with pytest.raises(LinkError, match=r"cannot open the bus socket bus://127\.0\.0\.1:1 \(.*check its address"):
        open_end("bus://127.0.0.1:1", None)
    done = run("probe", "/dev/no-such-port", "--model", "if1")
    assert done.code == 2
    assert done.err.startswith("axistwin: cannot open the port /dev/no-such-port (")
    assert "Errno" not in done.err
    assert run("probe", "/dev/no-such-port", "--model", "if1", "--report", "x.txt").code == 2


def test_the_report():
    _, end = controller("1811", part_number="94-012345-02B")
    found = probe("1811", end)
    kept = json.loads(json.dumps(found.as_dict()))
    assert kept["counts"] == {"same": 154, "differs": 2, "inconclusive": 0}
    assert kept["facts"] == {"part number": "94-012345-02B"}
    assert kept["seen_on_real_hardware"]["Requests"] > 50
    assert "<td>FDh part number</td>" in html(found)
    assert html(found).count("<tr") == 157


def test_help_has_examples():
    assert "axistwin probe bus://127.0.0.1:1811 --model 1811" in run("probe", "--help").out
