"""`check` for devices of others: unknown commands, values out of range, wrong framing, a request without its end."""

import pytest

from axistwin.bench import device_checker as checking
from axistwin.bench.models import product
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.devices import Device, Lines, Option, command, query
from axistwin.scenes.diagnostics import codes
from axistwin.scenes.diagnostics import fix as check_fix
from axistwin.scenes.diagnostics.checking import diagnose_text

from .stages import Module, Stage, said


def found(text: str, kind: type[Device] = Stage) -> list[Diagnostic]:
    return diagnose_text(text, ".talk", product(kind))


def told(text: str, kind: type[Device] = Stage) -> list[str]:
    return [
        f"{one.line}:{one.column}-{one.end[1]}: {one.message} ({one.chapter}) {one.code}" for one in found(text, kind)
    ]


def test_a_program_of_known_commands_is_fine():
    assert told("> 1PA100\\r\n+1\n< 0\\r\n> 2TP\\r1MD\\r\n> WAIT\\r") == []


def test_an_unknown_command_has_its_place_and_the_most_similar_one():
    (one,) = found("> 1TP\\r\n> 1PT\\r")
    assert (one.line, one.column, one.end, one.code) == (2, 3, (2, 6), "DV101")
    assert one.words == "unknown command '1PT': did you mean '1TP'?; write 1TP [DV101]"
    assert not one.fix.sure
    assert check_fix.apply("> 1TP\\r\n> 1PT\\r", one.fix.edits) == "> 1TP\\r\n> 1TP\\r"
    assert told("> QQQQQQ\\r") == [
        "1:3-9: unknown command 'QQQQQQ': `axistwin commands stage` lists all (Commands) DV101"
    ]


def test_a_value_out_of_range_is_marked_with_the_section_of_the_device():
    assert told("> 1PA100\\r2PA-900000\\r") == [
        "1:14-21: position -900000: expected position -100000…100000 steps (Absolute move) DV102"
    ]


def test_a_request_without_its_end_and_a_line_that_is_too_long():
    assert told("> 1TP") == ["1:3-6: the end of the request is missing: expected \\r (Framing) DV104"]
    assert told(f"> {'1' * 300}\\r") == ["1:3-303: a line is longer than 256 characters (Framing) DV103"]


class Several(Device):
    model, framing = "several", Lines(b"\n", ignore=b"\r", separator=b";", address="@3", ignore_case=True)

    @command("SET {value:float 0..1}", section="4.2")
    def set_value(self, value): ...

    @query("GET")
    def get(self): ...


def test_parts_of_a_line_have_their_own_places():
    """Characters that are ignored, and the address, are no part of a request."""
    assert told("> @3get;SET 2;PUT\\r\\n@4PUT\\r\\n", Several) == [
        "1:13-14: value 2.0: expected value 0.0…1.0 (4.2) DV102",
        "1:15-18: unknown command 'PUT': `axistwin commands several` lists all (Commands) DV101",
        f"1:22-27: {OTHER % '@3'} DV105",
    ]


class Bus(Stage):
    model, framing = "bus", Lines(b"\r", address="#{address:02d}")
    options = {**Stage.options, "address": Option(1, 1, 32)}


OTHER = "this unit reads only what begins with '%s': begin with it, or leave it to the unit it is for (Framing)"


def test_a_line_for_another_unit_or_without_an_address():
    assert told("> #011TP\\r\n> #021TP\\r1TP\\r\\r", Bus) == [
        f"2:3-9: {OTHER % '#01'} DV105", f"2:11-14: {OTHER % '#01'} DV105",
    ]  # fmt: skip
    other = product(Bus).with_options({"address": 2})
    assert [one.code for one in diagnose_text("> #021TP\\r#011TP\\r", ".talk", other)] == ["DV105"]
    assert product(Bus).with_options({"address": "two"}).check([]) == []


def test_a_line_without_its_end_that_another_one_follows():
    assert told("> 1TP\n> 2TP\\r\n> 1PA10\n> 1TP\\r\n> 1PA\n> 5\\r") == [
        "1:3-6: the end of the request is missing: expected \\r (Framing) DV104",
        "3:3-8: the end of the request is missing: expected \\r (Framing) DV104",
    ]


def test_a_value_in_the_wrong_form_is_marked():
    assert told("> 1PA1.5\\r7PA1\\r1PA\\r") == [
        "1:6-9: position '1.5': expected a whole number (Absolute move) DV102",
        "1:11-12: axis '7': expected 1 or 2 (Absolute move) DV102",
        "1:17-20: position '': expected a whole number (Absolute move) DV102",
    ]
    assert told("> #01\\r", Bus) == ["1:3-6: unknown command '': `axistwin commands bus` lists all (Commands) DV101"]


def test_datagrams():
    def line(data: bytes) -> str:
        return "> " + "".join(f"\\x{byte:02X}" for byte in data)

    good, wrong_motor, unknown = said(4, 0, "1", 100), said(4, 0, "7", 100), said(99, 0, "1")
    assert told(line(good), Module) == []
    assert told(line(good + wrong_motor), Module) == ["1:39-75: motor 7: expected motor 0…2 (MVP ABS) DV102"]
    assert told(line(unknown), Module) == [
        "1:3-39: unknown command 01 63 00 01 00 00 00 00 65: `axistwin commands module` lists all (Commands) DV101"
    ]
    assert told(line(good[:-1] + b"\x00"), Module) == ["1:3-39: the check sum is wrong (Framing) DV103"]
    assert told(line(good[:5]), Module)[0].endswith("expected all bytes of its datagram (Framing) DV104")


@pytest.mark.parametrize("rule", checking.RULES, ids=lambda rule: rule.code)
def test_the_example_of_a_code_has_this_diagnostic(rule):
    kind = Bus if rule is checking.OTHER else Stage
    assert {(one.code, one.severity) for one in found(rule.example, kind)} == {(rule.code, rule.severity)}
    assert rule in codes.select(rule.code) and codes.suffix_of(rule) == ".talk"


MENDED = {"DV101": "> 1PA5\\r", "DV102": "> 1PA90000\\r", "DV103": "> 1TP\\r", "DV104": "> 1TP\\r"}
MENDED_BUS = "> #011TP\\r"


@pytest.mark.parametrize("rule", checking.RULES, ids=lambda rule: rule.code)
def test_the_remedy_leads_out(rule):
    mended = (MENDED_BUS, Bus) if rule is checking.OTHER else (MENDED[rule.code],)
    assert found(*mended) == []
