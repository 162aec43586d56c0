"""Errors in a device: each names file, line and remedy, and the server and the bench go on."""

import logging
import textwrap
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import serial

import axistwin
from axistwin import Bench
from axistwin.bench.models import product
from axistwin.core.errors import UsageError

from ..told import raises

HEAD = """
from axistwin.devices import Datagrams, Device, Input, Lines, Positioner, command, query, register

class Stage(Device):
    model, pins = "stage", {"door": Input(), "end": Input(level=True)}
    axes = {"1": Positioner(minus="end", plus="end")}

    @query("TP")
    def tell_position(self):
        return self.axes["1"].position
"""


def written(folder: Path, body: str) -> Any:
    """Return the class of a device file with these lines in the class; the line with an error ends in `# here`."""
    text = HEAD + textwrap.indent(textwrap.dedent(body), "    ")
    file = folder / "stage.py"
    file.write_text(text, encoding="utf-8")
    module = ModuleType("stage")
    module.__file__ = str(file)
    exec(compile(text, str(file), "exec"), module.__dict__)
    return module.__dict__["Stage"]


def line_of(folder: Path) -> int:
    lines = (folder / "stage.py").read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, start=1) if line.endswith("# here"))


@pytest.mark.parametrize(("wrong", "meant"), [
    ("framng = 1", "framing"), ("axis = 1", ""), ("option = 1", "options"), ("titel = 1", "title"),
    ("modell = 'x'", ""), ("_framng = 1", ""),
    ("lines = {}", "line"), ("line, lines = '9600 8N1', {}", ""), ("status = defaults = 1", ""),
    ("def refuse(self): ...", "refused"), ("def pin_change(self): ...", "pin_changed"), ("def axis(self): ...", ""),
    ("def restart(self): ...", ""), ("@query('X')\ndef hints(self): ...", ""),
])  # fmt: skip
def test_an_attribute_that_is_nearly_one_of_ours(wrong, meant, tmp_path):
    kind = written(tmp_path, wrong)
    if not meant:
        assert product(kind).model == "stage"
        return
    name = wrong.removeprefix("def ").split("(")[0].split(" ")[0]
    said = f"stage.py: nothing reads '{name}' of class Stage: did you mean '{meant}'? If not, call it _{name}"
    with pytest.raises(UsageError) as error:
        product(kind)
    assert str(error.value) == said


FOUND_WHILE_RUNNING = {
    "a handler": ("""
        @command("GO")
        def go(self):
            self.axes["2"].move_to(5)  # here
        """, b"GO\r", "KeyError in stage: '2': mend the handler"),
    "a procedure": ("""
        @command("GO")
        def go(self):
            yield self.after(0.1)
            return 1 / 0  # here
        """, b"GO\r", "ZeroDivisionError in stage: division by zero: mend the handler"),
    "a procedure that yields a number": ("""
        @command("GO")
        def go(self):
            yield 0.1  # here
        """, b"GO\r", "TypeError in stage: yielded 0.1: expected an event, e.g. self.after(0.2)"),
    "an answer of a wrong type": ("""
        @query("GO")  # here
        def go(self):
            return ["a", "list"]
        """, b"GO\r", "TypeError in stage: returned list: expected text, a number, bytes or None"),
    "a query without an answer": ("""
        @query("GO")  # here
        def go(self):
            self.gone = True
        """, b"GO\r", "TypeError in stage: returned None: a query answers with text, a number or bytes"),
    "the answer to a refused line": ("""
        def refused(self, reason, data):
            return reason.number  # here
        """, b"GO\r", "AttributeError in stage: 'Refused' object has no attribute 'number'"),
    "memory that cannot be stored": ("""
        @command("GO")
        def go(self):
            self.memory["axes"] = self.axes
            self.save()  # here
        """, b"GO\r", "TypeError in stage:"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "sent", "words"), FOUND_WHILE_RUNNING.values(), ids=FOUND_WHILE_RUNNING)
def test_an_error_is_named_and_the_server_goes_on(body, sent, words, tmp_path, caplog):
    bench = Bench()
    controller = bench.add(written(tmp_path, body))
    told = []
    controller.subscribe_refusals(lambda refusal: told.append(refusal.why))
    caplog.set_level(logging.ERROR, "axistwin.devices")
    with axistwin.serve(bench, speed="manual") as twin, serial.serial_for_url(twin.ports["stage"], timeout=5) as host:
        host.write(sent)
        twin.advance(1.0)
        host.write(b"TP\r")
        twin.advance(1.0)
        assert host.read(2) == b"0\r"
    place = f"stage.py:{line_of(tmp_path)}: "
    assert any(why.startswith(place + words) for why in told)
    assert caplog.messages[0].startswith(place + words)


OUTSIDE_OF_REQUESTS = {
    "at power-on": ("def start(self):\n    self.axes['2'].stop()  # here", lambda one: None, "KeyError"),
    "at a pin": ("def pin_changed(self, name, level):\n    self.door = self.pins[level]  # here",
                 lambda one: one.pins["door"].drive(True), "KeyError"),
    "at a limit": ("def limit_reached(self, axis, side):\n    self.hits += 1  # here",
                   lambda one: (one._device.device.axes["1"].run(100), one.pins["end"].drive(False)), "AttributeError"),
    "in a register": ("@register()\ndef status(self) -> int:\n    return self.state  # here",
                      lambda one: one.read("status"), "AttributeError"),
    "in the hint": ("def hint(self):\n    return self.reason  # here", lambda one: one.hint, "AttributeError"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "act", "words"), OUTSIDE_OF_REQUESTS.values(), ids=OUTSIDE_OF_REQUESTS)
def test_so_is_an_error_that_no_request_has_caused(body, act, words, tmp_path, caplog):
    bench = Bench()
    with caplog.at_level(logging.ERROR, "axistwin.devices"):
        controller = bench.add(written(tmp_path, body))
        bench.run(0.5)
        act(controller)
        bench.run(0.5)
        controller.serial.write(b"TP\r")
        bench.run(0.5)
    assert controller.serial.read() == f"{controller.axes['1'].position}\r".encode()
    assert caplog.messages[0].startswith(f"stage.py:{line_of(tmp_path)}: {words} in stage: ")


def test_an_error_is_logged_once_but_each_refused_line_is_reported(tmp_path, caplog):
    body = """
        @command("GO")
        def go(self):
            return 1 / 0

        @register()
        def status(self) -> int:
            return self.state
        """
    bench, told = Bench(), []
    controller = bench.add(written(tmp_path, body), line="instant")
    controller.subscribe_refusals(lambda refusal: told.append(refusal.data))
    with caplog.at_level(logging.ERROR, "axistwin.devices"):
        for _ in range(20):
            controller.read("status")
            controller.serial.write(b"GO\r")
            bench.run(0.1)
    assert [words.split(" in ")[0] for words in caplog.messages] == [
        "stage.py:18: AttributeError", "stage.py:14: ZeroDivisionError",
    ]  # fmt: skip
    assert told == [b"", *[b"GO"] * 20]


FOUND_BEFORE = {
    "a kind": ('@command("GO{to:integer}")  # here\ndef go(self, to): ...',
               "invalid placeholder {to:integer}: expected a name and int"),
    "brackets": ('@command("GO[{to:int}")  # here\ndef go(self, to): ...', "expected pairs of brackets"),
    "a parameter": ('@command("GO{to:int}")  # here\ndef go(self, target): ...', "has no {target}: add it"),
    "two of one line": ('@query("T[P]")  # here\ndef tell(self): ...', "also matches 'TP', as 'TP' does at stage.py:8"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "words"), FOUND_BEFORE.values(), ids=FOUND_BEFORE)
def test_a_pattern_that_cannot_be_right_is_refused_before_anything_runs(body, words, tmp_path):
    with pytest.raises(UsageError) as raised:
        product(written(tmp_path, body))
    assert str(raised.value).startswith(f"stage.py:{line_of(tmp_path)}: ") and words in str(raised.value)
    assert "\n" not in str(raised.value)
    raises(UsageError, "has no model: add one", product, written(tmp_path, "model = None"))
