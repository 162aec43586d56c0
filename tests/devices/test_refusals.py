"""What a device refuses: empty messages, when the answer begins, and what a server tells of it."""

import axistwin
from axistwin import Bench
from axistwin.devices import Device, Lines, Refused, command, load
from axistwin.scenes.diagnostics.refused_lines import RefusedLines

from .made import ask, on_a_bench


class Meter(Device):
    """A device with an address, which answers after 3 ms, and some commands later."""

    model, framing, answer_after = "meter", Lines(b"\r", ignore=b" ", address="#01"), 0.003

    def refused(self, reason, data):
        return f"{reason.why.name} {data.decode()}"

    @command("GO{to:int 0..9}", after=0.5)
    def go(self, to):
        if to == 5:
            raise Refused("not now")
        return 1 // (to - 6)

    @command("WAIT", after=0.25)
    def wait(self):
        yield self.after(1)
        raise Refused("nothing came")


class Attentive(Meter):
    model = "attentive"

    @command("")
    def attention(self):
        return "HERE"


def test_an_empty_message_is_unknown_or_a_command_of_its_own():
    assert ask(*on_a_bench(Meter), b"\r \r#02\r#01 \r") == b"UNKNOWN \r"
    assert ask(*on_a_bench(Attentive), b"\r#01\r") == b"HERE\r"


def test_after_also_holds_for_the_refusals_of_a_command():
    made = on_a_bench(Meter)
    for line, answer in ((b"GO5", b"STATE GO5"), (b"GO10", b"RANGE GO10"), (b"GO6", b"BUG GO6")):
        assert ask(*made, b"#01" + line + b"\r", 0.499999) == b""
        assert ask(*made, b"", 0.000002) == answer + b"\r"
    for line, answer in ((b"X", b"UNKNOWN X"), (b"GO1.5", b"FORMAT GO1.5")):  # It is no such command.
        assert ask(*made, b"#01" + line + b"\r", 0.002999) == b""
        assert ask(*made, b"", 0.000002) == answer + b"\r"
    assert ask(*made, b"#01WAIT\r", 1.249999) == b""
    assert ask(*made, b"", 0.000002) == b"STATE WAIT\r"


def test_a_number_of_many_digits_is_out_of_range():
    refusals = []
    bench, controller = on_a_bench(Meter)
    controller.subscribe_refusals(refusals.append)
    assert ask(bench, controller, b"#01GO" + b"9" * 30 + b"\r", 1) == b"RANGE GO" + b"9" * 30 + b"\r"
    assert [one.why for one in refusals] == ["to 999999999999999999…: expected to 0…9"]


def test_a_server_names_the_list_of_commands_with_the_file(stage):
    load(stage)
    bench, told = Bench(), []
    bench.add("stage")
    RefusedLines(told.append).watch(bench)
    with axistwin.serve(bench, speed="manual"):
        bench["stage"].serial.write(b"1XX\r1PA1.5\r")
        bench.run(1)
    assert told == [
        f"stage: refused 1XX: unknown command '1XX': `axistwin --device {stage} commands stage` lists all",
        "stage: refused 1PA1.5: position '1.5': expected a whole number",
    ]
