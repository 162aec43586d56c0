"""Placeholders that allow some words only."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.devices import Device, Lines, command
from axistwin.devices.making import product_of

from .made import ask, on_a_bench


class Valves(Device):
    model, framing = "valves", Lines(ignore_case=True)

    @command("{valve:IN|INNER|+} {state:on|off}")
    def switch(self, valve, state):
        return f"{valve} {state}"

    def refused(self, reason, data):
        return "no"


@pytest.mark.parametrize(("line", "answer"), [
    (b"IN on", b"IN on"), (b"INNER off", b"INNER off"), (b"+ on", b"+ on"),
    (b"inner OFF", b"INNER off"),  # as the pattern writes it
    (b"INNE on", b"no"), (b"IN|INNER on", b"no"), (b"IN o", b"no"), (b" on", b"no"),
])  # fmt: skip
def test_the_words(line, answer):
    bench, controller = on_a_bench(Valves)
    assert ask(bench, controller, line + b"\r") == answer + b"\r"


def test_the_table_has_the_words():
    (entry,) = product_of(Valves).commands
    assert entry.syntax == "<IN|INNER|+> <on|off>"


def test_case_counts_where_it_counts():
    class Strict(Valves):
        model, framing = "strict", Lines()

        @command("SIDE {side:a|A}")
        def take(self, side):
            return side

    bench, controller = on_a_bench(Strict)
    assert ask(bench, controller, b"SIDE a\rSIDE A\r") == b"a\rA\r"
    assert ask(bench, controller, b"in on\r") == b"no\r"


def test_two_commands_with_the_same_word():
    class Twice(Valves):
        model = "twice"

        @command("IN {state:word}")
        def other(self, state): ...

    with pytest.raises(UsageError, match="also matches 'IN on'"):
        product_of(Twice)
