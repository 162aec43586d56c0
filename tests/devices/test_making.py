"""A class of a device on a bench: options, memory, procedures, registers, pins, refusals."""

import json
import logging

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.devices import Device, Input, Lines, Option, Output, Positioner, Refused, Why, command, query, register
from axistwin.devices.making import MOST_WAITING, product_of

from .made import ask, device, on_a_bench


class Stage(Device):
    """A device with a little of everything; an error is answered by its kind."""

    model, title = "stage", "Example stage"
    axes = {"X": Positioner(velocity=1000, acceleration=10_000)}
    pins = {"gate": Input(), "lamp": Output(), "ready": Output(level=True)}
    options = {
        "address": Option(1, 1, 255, doc="its number"), "gain": Option(0.5, 0, 2),
        "mode": Option("fast", choices=("fast", "slow")), "echo": Option(False),
    }  # fmt: skip
    memory = {"speed": 1000, "names": ["a"]}
    faults = ("overheated",)

    def start(self):
        self.count = 0
        self.seen = []

    def refused(self, reason, data):
        return f"E{reason.code or list(Why).index(reason.why)}"

    def pin_changed(self, name, level):
        self.seen.append((name, level))
        yield self.after(0.5)
        self.pins["lamp"].set(level)

    @command("SPEED {speed:int 1..5000}")
    def set_speed(self, speed):
        self.memory["speed"] = speed

    @command("SAVE")
    def keep(self):
        self.save()

    @query("SPEED?", after=0.25)
    def speed(self):
        return self.memory["speed"]

    @query("ALL?")
    def all_options(self):
        return " ".join(map(str, self.options.values()))

    @command("GO {position:int}")
    def go(self, position):
        self.axes["X"].move_to(position)
        yield self.axes["X"].done
        return "there"

    @command("HOLD", blocks=True)
    def hold(self):
        yield self.after(1)
        return "held"

    @command("GATE")
    def wait_for_the_gate(self):
        yield from self.until("gate")
        return "open"

    @command("WRONG {what}")
    def wrong(self, what):
        if what == "refused":
            raise Refused("not now", code=42)
        if what == "fault":
            self.fault("burnt")
        return {"type": [], "nothing": None}[what]

    @query("NOTHING?")
    def nothing(self): ...

    @command("STEP")
    def step(self):
        yield 0.2

    @command("LATER")
    def later(self):
        def say():
            yield self.after(0.1)
            self.send("!")
            self.fault("overheated")

        self.begin(say())

    @register({0: "moving", 3: "gate open"}, section="Status")
    def status(self):
        return self.axes["X"].moving + 8 * self.pins["gate"].level

    @register(restless=True)
    def place(self):
        return self.axes["X"].position

    @register()
    def words(self) -> str:
        return "moving" if self.axes["X"].moving else "idle"

    @register()
    def broken(self):
        return 1 // 0


@pytest.fixture
def stage():
    return on_a_bench(Stage)


def test_the_model():
    made = product_of(Stage)
    assert (made.model, made.title, made.axes, made.line.baudrate) == ("stage", "Example stage", ("X",), 9600)
    assert product_of(Stage) is made and len(made.commands) == 11


# Options


def test_options_have_their_usual_values_or_those_given():
    assert ask(*on_a_bench(Stage), b"ALL?\r") == b"1 0.5 fast False\r"
    given = {"address": 255, "gain": 2, "mode": "slow", "echo": True}
    assert ask(*on_a_bench(Stage, **given), b"ALL?\r") == b"255 2 slow True\r"


@pytest.mark.parametrize(("option", "message"), [
    ({"address": 0}, "address=0: expected a number from 1 to 255"),
    ({"address": 1.5}, "address=1.5: expected"), ({"address": True}, "address=True: expected"),
    ({"gain": 2.1}, "gain=2.1: expected a number from 0 to 2"), ({"gain": float("nan")}, "gain=nan: expected"),
    ({"mode": "idle"}, "mode='idle': expected one of 'fast', 'slow'"),
    ({"echo": 1}, "echo=1: expected true or false"),
    ({"speed": 1}, "model stage has no option 'speed': expected one of X, address, gain, mode, echo"),
])  # fmt: skip
def test_options_out_of_range(option, message):
    with pytest.raises(UsageError) as error:
        on_a_bench(Stage, **option)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(("wrong", "message"), [
    ({"model": None}, 'class Wrong has no model: add one, e.g. model = "stage"'),
    ({"memory": {"speed": b"1"}}, "invalid memory: Object of type bytes is not JSON serializable: expected numbers"),
    ({"framing": Lines(address="{adress}")}, "invalid address '{adress}': 'adress': expected the name of an option"),
    ({"axes": {"X": Positioner(home="end")}}, "axis X names 'end': add it to the pins, e.g. 'end': Input(level=True)"),
    ({"axes": {"X": Positioner(plus="end")}}, "axis X has one limit input: name two, an unused Input(level=True)"),
    ({"axes": {"line": Positioner()}}, "the name 'line' of an axis or option is in use: choose another"),
    ({"axes": {"X": Positioner()}, "options": {"X": Option(1)}}, "the name 'X' of an axis or option is in use"),
    ({"options": {"address": 1}}, "option address is 1: expected Option(...), e.g. Option(1, 1, 255)"),
    ({"line": "fast"}, "invalid baud rate or character format 'fast'"),
])  # fmt: skip
def test_figures_that_cannot_be_right(wrong, message):
    with pytest.raises(UsageError) as error:
        Bench().add(product_of(type("Wrong", (Device,), {"model": "wrong", **wrong})))
    assert message in str(error.value)


# Memory and power


def test_only_what_was_saved_is_kept_without_power(stage):
    bench, controller = stage
    assert ask(bench, controller, b"SPEED 7\rSPEED?\r", 0.5) == b"7\r"
    controller.power_cycle()
    bench.run(1)
    assert ask(bench, controller, b"SPEED?\r", 0.5) == b"1000\r"
    ask(bench, controller, b"SPEED 7\rSAVE\rSPEED 8\r")
    controller.power_cycle()
    bench.run(1)
    assert ask(bench, controller, b"SPEED?\r", 0.5) == b"7\r"
    device(controller).memory["names"].append("b")
    assert Stage.memory == {"speed": 1000, "names": ["a"]}


@pytest.mark.parametrize(("contents", "speed"), [
    (json.dumps({"speed": 5, "old": 1}), b"5\r"), ("[1]", b"1000\r"), ("{damaged", b"1000\r"), ("", b"1000\r"),
])  # fmt: skip
def test_a_file_of_memory(tmp_path, contents, speed):
    (tmp_path / "stage.json").write_text(contents)
    assert ask(*on_a_bench(Stage, state=tmp_path), b"SPEED?\rSAVE\r", 0.5) == speed
    assert json.loads((tmp_path / "stage.json").read_text()) == {"speed": int(speed), "names": ["a"]}


def test_the_power_ends_motion_procedures_and_answers(stage):
    bench, controller = stage
    device(controller).pins["ready"].set(False)
    ask(bench, controller, b"GO 5000\rHOLD\rSPEED?\r", 0.3)
    controller.power(False)
    at = controller.axes["X"].position
    assert at > 0 and controller.registers["words"].read() == "off"
    assert controller.pins["ready"].level
    bench.run(10)
    controller.power(True)
    bench.run(0.1)
    assert (controller.axes["X"].position, ask(bench, controller, b"GO 0\r", 1)) == (at, b"there\r")


# Times and procedures


def test_an_answer_begins_at_its_time(stage):
    bench, controller = stage
    assert ask(bench, controller, b"SPEED?\r", 0.249) == b""
    assert ask(bench, controller, b"", 0.001) == b"1000\r"


def test_a_procedure_answers_at_its_end_and_others_are_answered_meanwhile(stage):
    bench, controller = stage
    assert ask(bench, controller, b"GO 500\rALL?\r", 0.59) == b"1 0.5 fast False\r"  # 0.5 s and a ramp of 0.1 s
    assert controller.busy
    assert ask(bench, controller, b"", 0.02) == b"there\r"


def test_requests_wait_for_a_procedure_that_blocks(stage):
    bench, controller = stage
    assert ask(bench, controller, b"HOLD\rALL?\rHOLD\rSPEED 9\r", 0.99) == b""
    assert ask(bench, controller, b"", 0.02) == b"held\r1 0.5 fast False\r"
    assert device(controller).memory["speed"] == 1000
    assert ask(bench, controller, b"", 1) == b"held\r"
    assert device(controller).memory["speed"] == 9


def test_at_most_64_requests_wait(stage):
    bench, controller = stage
    assert ask(bench, controller, b"HOLD\r" + b"ALL?\r" * (MOST_WAITING + 2), 0.5) == b"E3\r" * 2
    assert ask(bench, controller, b"", 1) == b"held\r" + b"1 0.5 fast False\r" * MOST_WAITING


def test_a_procedure_waits_for_a_pin(stage):
    bench, controller = stage
    assert ask(bench, controller, b"GATE\r", 1) == b""
    assert device(controller).awaited[1:] == ("gate", "high")
    controller.pins["gate"].drive(True)
    assert ask(bench, controller, b"", 0.4) == b"open\r" and device(controller).awaited is None
    assert not controller.pins["lamp"].level
    bench.run(0.2)
    assert controller.pins["lamp"].level and device(controller).seen == [("gate", True)]


def test_a_message_that_nobody_asked_for_and_a_fault(stage):
    bench, controller = stage
    heard = []
    controller.alarms.subscribe(heard.append)
    assert ask(bench, controller, b"LATER\r", 0.2) == b"!\r"
    assert heard == ["overheated"]


def test_a_device_listens_when_its_start_has_ended():
    class Slow(Stage):
        model, answer_after = "slow", 0.5

        def start(self):
            yield self.after(2)
            self.send("READY")

    bench, controller = on_a_bench(Slow)
    assert ask(bench, controller, b"ALL?\r", 0.9) == b""
    assert ask(bench, controller, b"", 0.2) == b"READY\r"  # without the delay of answers
    assert ask(bench, controller, b"ALL?\r", 0.49) == b""
    assert ask(bench, controller, b"", 0.02) == b"1 0.5 fast False\r"


# Registers and the front panel


def test_registers(stage, caplog):
    bench, controller = stage
    controller.pins["gate"].drive(True)
    ask(bench, controller, b"GO 100\r", 0.1)
    assert {name: controller.read(name) for name in ("status", "place", "words")} == {
        "status": 9, "place": 50, "words": "moving",
    }  # fmt: skip
    assert controller.read("broken") == 0
    assert "ZeroDivisionError" in caplog.text


def test_the_front_panel():
    groups = {group.title: [item.name for item in group.items] for group in product_of(Stage).front}
    assert groups == {
        "status": ["moving", "gate open"], "place": ["place"], "words": ["words"], "broken": ["broken"],
        "Terminals": ["gate", "lamp", "ready"],
    }  # fmt: skip
    lamps = product_of(Stage).front[0].items
    assert [(lamp.source, lamp.bit) for lamp in lamps] == [("status", 0), ("status", 3)]


# Refusals


@pytest.mark.parametrize(("line", "answer", "why"), [
    (b"NONSENSE", b"E0\r", "unknown command 'NONSENSE'"),
    (b"SPEED 0", b"E1\r", "speed 0: expected speed 1…5000"),
    (b"WRONG refused", b"E42\r", "not now"),
    (b"WRONG other", b"E4\r", "KeyError in stage: 'other': mend the handler"),
    (b"WRONG type", b"E4\r", "TypeError in stage: returned list: expected text, a number, bytes or None"),
    (b"WRONG fault", b"E4\r", "ValueError in stage: no fault 'burnt': expected one of overheated"),
    (b"WRONG nothing", b"", None),
    (b"NOTHING?", b"E4\r", "TypeError in stage: returned None: a query answers with text, a number or bytes"),
    (b"A" * 300, b"E2\r", "a line is longer than 256 characters"),
])  # fmt: skip
def test_refusals_are_answered_and_reported(stage, line, answer, why):
    bench, controller = stage
    refusals = []
    controller.subscribe_refusals(refusals.append)
    assert ask(bench, controller, line + b"\r") == answer
    assert [refusal.why for refusal in refusals] == ([] if why is None else refusals and [refusals[0].why])
    assert why is None or why in refusals[0].why
    assert ask(bench, controller, b"ALL?\r") == b"1 0.5 fast False\r"


def test_an_error_names_file_and_line_and_the_device_goes_on(stage, caplog):
    bench, controller = stage
    with caplog.at_level(logging.ERROR, "axistwin.devices"):
        assert ask(bench, controller, b"WRONG other\r") == b"E4\r"
    line = Stage.wrong.__code__.co_firstlineno + 6
    assert caplog.messages == [f"test_making.py:{line}: KeyError in stage: 'other': mend the handler"]


def test_a_class_without_a_source_file_works_too():
    namespace = {}
    exec("from axistwin.devices import Device, query\nclass Typed(Device):\n    model = 'typed'\n"
         "    @query('A?')\n    def a(self): return 1 // 0\n    @query('B?')\n    def b(self): return 2\n",
         namespace)  # fmt: skip
    bench, controller = on_a_bench(namespace["Typed"])
    refusals = []
    controller.subscribe_refusals(refusals.append)
    assert ask(bench, controller, b"A?\rB?\r") == b"2\r"
    assert refusals[0].why.startswith("<string>:5: ZeroDivisionError in typed")
