"""Faults that wait for a line of a program: `motor runs 12`, `table runs 5`, `board runs 3:2`."""

import pytest

from axistwin import Bench
from axistwin.bench.faults import sentences, triggers
from axistwin.bench.talk.conversation import parse
from axistwin.bench.talk.player import play
from axistwin.controllers.product import Abilities
from axistwin.controllers.registry import OURS
from axistwin.core.errors import ProgramError, UsageError

SAMPLE_NS = 245_760
IF1 = "+1.5\n> (\n< U\\r\n> U61\\r\n+1.2\n"
PROGRAM = "A=100 V=65536\nMP\nC5\na=a+1\nWAIT=10\nIF a<4\nGOTO5\nENDIF\nEND\n"


@pytest.fixture
def table():
    bench = Bench()
    bench.add("if1", name="table")
    assert play(parse(IF1), bench) is None
    return bench


@pytest.fixture
def motor():
    bench = Bench()
    motor = bench.add("smartmotor", name="motor", line="instant")
    motor.serial.write(b"UCI UDI ZS LOAD ")
    motor.serial.write(PROGRAM.encode() + b"\xff\xff ")
    bench.clock.run_to(1000 * SAMPLE_NS)
    assert len(motor.programs["program"].lines) == 9
    return bench


@pytest.fixture
def board():
    """Return an 1811 whose sequences 3 and 4 switch output 1 off and on."""
    bench = Bench()
    bench.add("1811", name="board")
    define = "> begin_sequence_definition {}\n> clear_output 1\n> set_output 1\n> end_sequence_definition\n"
    talk = "; model: 1811\n+1.1\n" + define.format(3) + define.format(4) + "+0.1\n"
    assert play(parse(talk), bench) is None
    return bench


def happens(bench, sentence):
    times = []
    triggers.read(sentence, bench)(lambda: times.append(bench.now))
    return times


def test_a_step_of_a_sequence(table):
    """3 steps at the start/stop speed of 400 take 7.5 ms, an output takes 1 ms; step 4 repeats steps 2 and 3 once."""
    first, third, outputs = happens(table, "table runs 1"), happens(table, "table runs 3"), []
    table["table"].pins["output1"].subscribe(lambda pin: outputs.append(table.now))
    assert play(parse("> :S2:X3@400:S1R1:=1,2:$\\r\n+0.2\n"), table) is None
    (began,) = first
    assert third == [began + 8_500_000, began + 18_000_000]
    assert outputs[::2] == third, "outputs change when the step begins"


def test_a_line_of_a_program(motor):
    """Line 1 runs in samples 1 and 2, MP in 3, a=a+1 in 4, WAIT=10 in 5, IF in 15, GOTO in 16, a=a+1 in 17."""
    found, zero_ns = happens(motor, "motor runs 4"), motor.now
    motor["motor"].serial.write(b"RUN ")
    motor.run(1)
    assert found == [zero_ns + (4 + 13 * n) * SAMPLE_NS for n in range(4)]


def test_a_command_of_a_sequence(board):
    """The first command begins 1 ms after the request."""
    second, other = happens(board, "board runs 3:2"), happens(board, "board runs 4:2")
    falls = []
    board["board"].pins["output1"].subscribe(lambda pin: falls.append((board.now, pin.level)))
    assert play(parse("; model: 1811\n> perform_sequence 3\n+0.1\n"), board) is None
    assert falls == [(second[0], False), (second[0] + 1_000_000, True)] and other == []


def test_a_fault_begins_at_a_line_and_ends_after_its_duration(motor):
    fault = motor.faults.add("stuck", "motor.E", level=False, when="motor runs 4", nth=3, duration=0.25)
    zero_ns, levels = motor.now, []
    motor["motor"].pins["E"].subscribe(lambda pin: levels.append((motor.now - zero_ns, pin.level)))
    motor["motor"].serial.write(b"RUN ")
    motor.run(1)
    began_ns = 30 * SAMPLE_NS
    assert fault.began_ns == zero_ns + began_ns and levels == [(began_ns, False), (began_ns + 250_000_000, True)]


def test_power_is_cut_at_a_line_of_each_family(table, motor, board):
    for bench, name, line, start in (
        (table, "table", "2", "> :H1:X500@400:Y500:$\\r\n+0.1\n! input1 high\n+0.1\n"),
        (motor, "motor", "5", "> RUN\\r\n+0.1\n"),
        (board, "board", "4:1", "; model: 1811\n> perform_sequence 4\n+0.1\n"),
    ):
        fault = bench.faults.add("power_cut", name, when=f"{name} runs {line}")
        assert play(parse(start), bench) is None and fault.on
        assert [found.running for found in bench[name].programs.values()] in ([None], [])


def test_a_trigger_accepts_a_program_that_is_stored_later(table):
    found = happens(table, "table runs 2")
    called_off = table.faults.add("jam", "table.X", when="table runs 2")
    called_off.mend()
    assert play(parse("> :S1:R1:$\\r\n+0.1\n> :$\\r\n+0.1\n"), table) is None
    assert len(found) == 2 and called_off.began_ns is None


@pytest.mark.parametrize(("fixture", "sentence", "message"), [
    ("motor", "motor runs", "invalid event when='motor runs': expected e.g. 'motor runs 12'"),
    ("motor", "motor runs C5", "invalid event when='motor runs C5': expected e.g. 'motor runs 12'"),
    ("motor", "motor runs 1:5", "invalid event when='motor runs 1:5': expected e.g. 'motor runs 12'"),
    ("motor", "motor runs 0", "invalid line number 0 in a program of motor: expected 1 or more"),
    (
        "motor",
        "motor runs 3",
        (
            "program line 3 (C5) of motor contains nothing to execute, "
            "so no fault can begin at this line: expected line 4 (a=a+1)"
        ),
    ),
    (
        "motor",
        "motor runs 8",
        (
            "program line 8 (ENDIF) of motor contains nothing to execute, "
            "so no fault can begin at this line: expected line 9 (END)"
        ),
    ),
    ("motor", "engine runs 8", "unknown controller 'engine': expected one of motor"),
    ("table", "table runs 64", "invalid line number 64 in a program of table: expected 1 to 63"),
    ("table", "table runs 3:2", "invalid event when='table runs 3:2': expected e.g. 'table runs 12'"),
    ("board", "board runs 2", "invalid event when='board runs 2': expected e.g. 'board runs 3:2'"),
    ("board", "board runs 3:0", "invalid line number 0 in a program of board: expected 1 or more"),
    ("board", "board runs 16:1", "board has no program 16: expected sequence 1 to sequence 15"),
    ("board", "board runs ³:1", "invalid event when='board runs ³:1': expected e.g. 'board runs 3:2'")])  # fmt: skip
def test_errors_have_a_remedy(request, fixture, sentence, message):
    bench = request.getfixturevalue(fixture)
    with pytest.raises(UsageError) as told:
        sentences.read(f"power_cut {fixture} when='{sentence}'", bench.faults)
    assert str(told.value) == message
    with pytest.raises(ProgramError, match=r"t\.talk:2"):
        play(parse(f"+1\n! fault power_cut when='{sentence}'\n", "t.talk"), bench)


def test_a_device_without_programs_refuses_the_trigger(table, monkeypatch):
    controller = table["table"]
    monkeypatch.setattr(controller, "product", controller.product._replace(programs=()))
    with pytest.raises(UsageError, match="table cannot store programs: expected a controller that stores programs"):
        triggers.read("table runs 1", table)
    monkeypatch.setattr(controller, "_abilities", Abilities())
    assert controller.programs == {}
    controller.subscribe_lines(print)()


@pytest.mark.parametrize("model", OURS)
def test_the_programs_of_a_controller_are_those_of_its_product(model):
    controller = Bench().add(model)
    assert set(controller.programs) <= set(controller.product.programs) and controller.product.programs


def test_a_fault_that_is_mended_while_it_begins_ends_at_once():
    """A subscriber to the edge that the fault causes mends the fault."""
    bench = Bench()
    if1 = bench.add("if1")
    bench.run(1)
    pin = if1.pins["input1"]
    pin.subscribe(lambda changed: changed.level and bench.faults.mend("all"))
    fault = bench.faults.add("stuck", "if1.input1", level=True)
    bench.run(0)
    assert not fault.on and not pin.held and not pin.level
