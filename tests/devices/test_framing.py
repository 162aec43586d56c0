"""Framing: what becomes of the characters on a line, and how answers are written."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.devices import Datagrams, Device, Lines, Option, add8, command, query, xor8
from axistwin.devices.framing import Port
from axistwin.devices.making import product_of
from axistwin.sim.frames import SOUND, LineError

from .made import ask, on_a_bench


class Listener:
    """A port that keeps what a reader passes on; time passes by hand."""

    def __init__(self, framing, address=b""):
        self.taken, self.echoed, self.now = [], b"", 0
        port = Port(address, self.take, self.echo, lambda: self.now)
        self.receive = framing.reader(port)

    def take(self, data, reason):
        self.taken.append(data if reason is None else (data, reason.words))

    def echo(self, data):
        self.echoed += data

    def hear(self, data, errors=SOUND):
        for byte in data:
            self.receive(byte, errors)
        return self.taken


@pytest.mark.parametrize(("framing", "sent", "taken"), [
    (Lines(), b"1PA100\r2TP\r", [b"1PA100", b"2TP"]),
    (Lines(), b"\r\r1TP", []),                                      # empty lines, and one without its end
    (Lines(ignore=b" \n"), b" \r 1 TP \r\n", [b"1TP"]),             # what is ignored is said, and nothing else is
    (Lines(), b" \r1TP\n\r\x0b1TP\r", [b" ", b"1TP\n", b"\x0b1TP"]),
    (Lines(b"\r\n"), b"A\rB\nC\r\nD\r\n", [b"A\rB\nC", b"D"]),
    (Lines(ignore=b"\n"), b"A\r\nB\r\n", [b"A", b"B"]),
    (Lines(separator=b";"), b"1PA100;;2TP; 3TP\r", [b"1PA100", b"2TP", b" 3TP"]),
])  # fmt: skip
def test_lines(framing, sent, taken):
    assert Listener(framing).hear(sent) == taken


def test_only_lines_for_the_address_are_read():
    listener = Listener(Lines(separator=b";", address="{address:02d}:"), b"03:")
    assert listener.hear(b"03:TP;TS\r04:TP\rTP\r03:MO\r") == [b"TP", b"TS", b"MO"]
    assert listener.hear(b"04:TP\r", LineError.PARITY)[3:] == []


def test_an_empty_line_is_dropped_but_not_behind_an_address():
    listener = Listener(Lines(separator=b";", address="{address:02d}:"), b"03:")
    assert listener.hear(b"\r03:\r04:\r03:TP;;\r") == [b"", b"TP"]


def test_every_character_is_echoed_also_the_ignored():
    listener = Listener(Lines(echo=True, ignore=b"\n"))
    listener.hear(b"AB\r\n")
    assert listener.echoed == b"AB\r\n"
    assert Listener(Lines()).echoed == b""


def test_a_line_with_a_wrong_character_is_refused_once_and_the_next_is_sound():
    listener = Listener(Lines(separator=b";"))
    listener.hear(b"TP;T")
    listener.hear(b"S", LineError.FRAMING)
    assert listener.hear(b"\rMO\r") == [(b"TP;TS", "a character was received with an error"), b"MO"]


def test_a_line_that_is_too_long_is_refused_as_a_whole():
    listener = Listener(Lines(b"\r\n", most=8))
    assert listener.hear(b"12345678\r\n") == [b"12345678"]
    assert listener.hear(b"123456789" * 1000 + b"TP\r\nTP\r\n")[1:] == [
        (b"12345678", "a line is longer than 8 characters"), b"TP",
    ]  # fmt: skip


@pytest.mark.parametrize("wrong", [{"terminator": b""}, {"terminator": b"\r\n", "ignore": b"\n"}])
def test_a_terminator_that_cannot_end_a_line_is_an_error(wrong):
    with pytest.raises(UsageError, match="expected characters that are not ignored"):
        Lines(**wrong)


@pytest.mark.parametrize(("framing", "answer", "written"), [
    (Lines(), "on", b"on\r"), (Lines(), 12, b"12\r"), (Lines(), 1.5, b"1.5\r"), (Lines(), b"raw", b"raw"),
    (Lines(b"\r", ending=b"\r\n>"), "", b"\r\n>"), (Lines(b"\n"), "5 µm €", b"5 \xb5m ?\n"),
])  # fmt: skip
def test_answers_of_lines(framing, answer, written):
    assert framing.written(answer) == written


@pytest.mark.parametrize("answer", [None, True, [1], {"a": 1}])
def test_what_is_no_answer_of_a_line(answer):
    with pytest.raises(TypeError, match="expected text, a number, bytes or None"):
        Lines().written(answer)


def test_check_sums():
    assert add8(bytes([1, 4, 0, 0, 0, 0, 3, 0xE8])) == b"\xf0"  # 1 + 4 + 3 + 232 = 240
    assert add8(b"\xff\x02") == b"\x01"
    assert xor8(b"\x0f\xff\x01") == b"\xf1"
    assert xor8(b"") == b"\0"


FIXED = Datagrams(">BBh address code value", ">Bh code value", add8)


def test_datagrams_of_fixed_length():
    listener = Listener(FIXED, b"\x01")
    sent = bytes([1, 4, 0xFF, 0xFE, 0x02])  # 1 + 4 + 255 + 254 = 514
    assert listener.hear(sent + sent) == [sent, sent]
    assert listener.hear(bytes([2, 4, 0, 0, 6]))[2:] == []  # for another device
    wrong = bytes([1, 4, 0, 0, 6])
    assert listener.hear(wrong)[2:] == [(wrong, "the check sum is wrong")]
    assert listener.hear(bytes([1, 4, 0, 0, 5]), LineError.PARITY)[3:] == [
        (wrong[:4] + b"\x05", "the check sum is wrong")
    ]
    assert listener.hear(sent)[4:] == [sent]


def test_the_rest_of_a_datagram_is_no_longer_expected_after_a_gap():
    listener = Listener(FIXED)
    sent = bytes([1, 4, 0, 0, 5])
    listener.hear(sent[:2])
    listener.now = 100_000_000
    assert listener.hear(sent[2:]) == [sent]
    listener.hear(sent[:2])
    listener.now += 100_000_001
    assert listener.hear(sent)[1:] == [sent]


def test_datagrams_with_a_length():
    listener = Listener(Datagrams("<BB code size", "<B code", xor8, length="size"))
    sent = [bytes([7, 0, 7]), bytes([7, 3, 1, 2, 4, 3])]  # 7 ^ 3 ^ 1 ^ 2 ^ 4 = 3
    assert listener.hear(b"".join(sent)) == sent


@pytest.mark.parametrize(("answer", "written"), [
    ({"code": 4, "value": -2}, bytes([4, 0xFF, 0xFE, 0x01])), (b"raw", b"raw"),
    ({"code": 4, "value": 3, "x": 1}, bytes([4, 0, 3, 7])),
])  # fmt: skip
def test_answers_of_datagrams(answer, written):
    assert FIXED.written(answer) == written


@pytest.mark.parametrize(("answer", "message"), [
    ("text", "returned str: expected the fields of an answer"),
    ({"code": 4}, "without the field 'value': expected code, value"),
    ({"code": 4, "value": 40_000}, "does not fit '>Bh code value'"),
])  # fmt: skip
def test_what_is_no_answer_of_a_datagram(answer, message):
    with pytest.raises(TypeError, match=message):
        FIXED.written(answer)


class Addressed(Device):
    """A device on a shared line, which ignores case."""

    model = "addressed"
    framing = Lines(b"\n", ending=b"\r\n", separator=b";", ignore_case=True, address="{address:02d}")
    options = {"address": Option(1, 1, 99, doc="its number on the line")}

    @query("ID")
    def identify(self):
        return f"no. {self.options['address']}"


class Module(Device):
    """A module with one value, and a block of data."""

    model = "module"
    framing = Datagrams(">BBB address code size", ">BB code value", add8, length="size", address="{address:c}")
    options = {"address": Option(1, 1, 255)}

    def start(self):
        self.value = 0

    @command("code=1")
    def store(self, data):
        self.value = len(data)

    @query("code=2 {size:int 0..1}")
    def read(self, code):
        return {"code": code, "value": self.value}


def test_requests_are_written_from_values():
    store, read = product_of(Module).commands
    assert Module.framing.phrase(store, {"size": 0, "code": "a"}, b"\x07") == bytes([7, 1, 0, 8])
    assert [parameter.example("X") for parameter in read.parameters] == [0]
    assert Lines(b"\n", at_once=b"!").phrase(next(iter(product_of(Addressed).commands)), {}, b"07") == b"07ID\n"


def test_an_addressed_device_on_a_bench():
    bench, controller = on_a_bench(Addressed, address=7)
    assert ask(bench, controller, b"07id;ID\n01ID\n") == b"no. 7\r\nno. 7\r\n"


def test_a_module_on_a_bench():
    bench, controller = on_a_bench(Module, address=200)
    assert ask(bench, controller, bytes([200, 1, 3, 9, 9, 9]) + add8(bytes([200, 1, 3, 9, 9, 9]))) == b""
    assert ask(bench, controller, bytes([200, 2, 0, 202])) == bytes([2, 3, 5])
    assert ask(bench, controller, bytes([200, 2, 2, 9, 9, 222])) == b""  # more data than its range allows
    assert ask(bench, controller, bytes([1, 2, 0, 3])) == b""
