"""`axistwin shadow --ask`: what is sent to the machine, when, and what the twin takes from it; in virtual time."""

import asyncio

import pytest

from axistwin.bench import product
from axistwin.core.units import S
from axistwin.devices import Datagrams, Device, Lines, Positioner, command, query
from axistwin.devices.making import product_of
from axistwin.drivers import TextDriver
from axistwin.links.urls import parse
from axistwin.real.probing.smartmotor.still import still
from axistwin.real.shadow.asking import QUESTIONS, Asker, questions_of
from axistwin.real.shadow.board_asking import BoardAsker
from axistwin.real.shadow.bus_relay import BusRelay

from ..devices.conftest import names  # noqa: F401  # a fixture
from .campaign import campaign

pytestmark = pytest.mark.usefixtures("names")


class Asked(campaign.Rig):
    """A machine with a shadow that asks.  `sent`: what the machine receives besides the host's own data."""

    def __init__(self, model, *before, **settings):
        super().__init__(model, jitter_ns=0, **settings)
        if before:
            self.machine.private(*before, seconds=1.3)
        self.sent, self.host, self._held = [], bytearray(), None
        self.to_host = self._arriving
        self.asker = Asker(product(model), self._send, self._release, self._tell)
        self.asker.begin(self.now / S)

    def _send(self, data):
        self.sent.append(data)
        self._held = []
        self.machine.write(data)

    def _release(self, rest):
        held, self._held = self._held, None
        self.host += rest
        for data in held:
            self.say(data)

    def _tell(self, by_host, data):
        (self.shadow.host if by_host else self.shadow.machine)(self.now, data)

    def _arriving(self, data):
        if self._held is not None:
            self.asker.received(self.now / S, data)
            return b""
        self.asker.passed(self.now / S, False, data)
        self.host += data
        return data

    def say(self, data):
        if self._held is not None:
            self._held.append(data)
        else:
            self.asker.passed(self.now / S, True, data)
            super().say(data)

    def wait(self, seconds):
        for _ in range(round(seconds * 100)):
            self.run(0.01)
            self.asker.tick(self.now / S)

    @property
    def notes(self):
        return [note.text for note in self.found]


@pytest.mark.parametrize(
    ("model", "before", "sent"),
    [
        ("if1", (b"(", b"U61\r"), [b"I\r\n", b"I\r", b"I\r", b"E\r\n", b"N\r"]),
        ("if1", (b"(", b"U62\r"), [b"I\r\n", b"I\r", b"I\r", b"E\r\n", b"N\r"]),  # echoes
        ("if1", (b"(", b"V61\r\n"), [b"I\r\n", b"I\n", b"I\n", b"E\r\n", b"N\n"]),
        ("smartmotor", (), [b"RW\r", b"RW\r", b"RBt\r", b"RP\r"]),
        ("smartmotor", (b"ECHO ",), [b"RW\r", b"RW\r", b"RBt\r", b"RP\r"]),
    ],
)
def test_the_machine_is_asked_once_and_the_host_hears_nothing(model, before, sent):
    rig = Asked(model, *before)
    rig.wait(3)
    assert (rig.sent, bytes(rig.host)) == (sent, b"")
    assert rig.shadow.following and rig.differences() == []


def test_the_twin_begins_in_the_machines_state():
    rig = Asked("smartmotor", b"O=4711 ")
    rig.machine.drive("C", True)  # the right limit
    rig.wait(2)
    assert rig.shadow.twin.private(b"RP\r") == b"4711\r" and rig.shadow.twin.level("C")
    assert "the machine says right limit open" in rig.notes


def test_a_machine_that_moves_is_asked_for_its_position_when_it_rests():
    rig = Asked("smartmotor", b"A=200 V=1000000 P=40000 MP G ")
    rig.wait(1)
    assert rig.sent[-1] == b"RBt\r"
    rig.wait(10)
    assert rig.sent[-1] == b"RP\r" and rig.sent.count(b"RP\r") == 1
    assert rig.shadow.twin.private(b"RP\r") == b"40000\r" and rig.differences() == []


def test_a_fault_from_before_is_no_finding():
    rig = Asked("if1", b"(", b"U61\r")
    for level in (False, True):
        rig.machine.drive("estop", level)
    rig.wait(20)
    assert b"E\r\n" in rig.sent and rig.found == []


def test_nothing_is_asked_between_a_request_and_its_answer():
    rig = Asked("if1", b"(", b"U61\r")
    rig.to_machine = lambda data: b""  # the answer takes long
    rig.say(b"E\r")
    rig.wait(1.9)
    assert rig.sent == []
    rig.wait(0.3)
    assert rig.sent[0] == b"I\r\n"


@pytest.mark.parametrize(
    ("model", "half", "rest"), [("if1", b"X1", b"00$\r"), ("smartmotor", b"LOAD a=1 ", b"END \xff\xff")]
)
def test_nothing_is_asked_within_a_command_or_a_program(model, half, rest):
    rig = Asked(model, *((b"(", b"U61\r") if model == "if1" else ()))
    rig.say(half)
    rig.wait(10)
    assert rig.sent == []
    rig.say(rest)
    rig.wait(10)
    assert rig.sent[0] == questions_of(product(model))[0].data


def test_the_hosts_data_wait_for_the_end_of_a_request():
    rig = Asked("if1", b"(", b"U61\r")
    while not rig.sent:
        rig.wait(0.01)
    rig.say(b"E\r")
    rig.wait(1)
    assert bytes(rig.host) == b"C\r"


def test_what_the_machine_says_by_itself_goes_to_the_host():
    rig = Asked("smartmotor")
    while not rig.sent:
        rig.wait(0.01)
    rig._arriving(b"Ready\r")
    rig.wait(2)
    assert bytes(rig.host) == b"Ready\r" and rig.sent[-1] == b"RP\r"


def test_a_machine_that_is_off_is_asked_when_it_answers_its_host():
    rig = Asked("smartmotor")
    rig.controller.power(False)
    rig.wait(5)
    assert rig.sent == [b"RW\r"] and rig.found == []
    rig.controller.power(True)
    rig.run(1)
    rig.say(b"RP\r")
    rig.wait(5)
    assert rig.sent[1:] == [b"RW\r", b"RW\r", b"RBt\r", b"RP\r"] and bytes(rig.host) == b"0\r"


def test_only_requests_that_change_nothing_are_asked():
    assert all(still(question.data.decode().strip()) for question in QUESTIONS["smartmotor"])
    assert {question.data.strip() for question in QUESTIONS["digiplan"]} <= {b"E", b"I", b"N", b"O"}
    assert all(0x80 <= question.data[0] <= 0x9F for question in QUESTIONS["compumotor"])


@pytest.mark.parametrize(
    ("members", "sent"),
    [
        ({"framing": Lines(b"\r\n"), "driver": TextDriver("{axis}PA{position}", "{axis}TP", "{axis}MD")},
         ["1MD\r\n", "1TP\r\n"]),
        ({"speed": query("SPEED?")(lambda self: 5), "dial": query("{n:int}D")(lambda self, n: n)}, ["SPEED?\r"]),
        ({"go": command("GO")(lambda self: None)}, []),
        ({"framing": Datagrams(">B code", ">B code"), "ask": query("code=4")(lambda self: 0)}, []),
        ({"framing": Datagrams(">Bx code", ">B code"), "driver": TextDriver(
            lambda position: b"M", lambda axis: b"P" + axis.encode(), lambda axis: b"B" + axis.encode(), size=1)},
         ["B1", "P1"]),
    ],
)  # fmt: skip
def test_a_device_is_asked_what_its_driver_or_its_table_calls_a_question(members, sent):
    made = product_of(type("Asked", (Device,), {"model": "asked", "axes": {"1": Positioner()}, **members}))
    assert [question.data.decode() for question in questions_of(made)[1:]] == sent


@pytest.mark.parametrize(
    ("moving", "idle", "asked"),
    [
        (0, 0x50, "88 89 94 97 8c 83"),
        (1, 0x50, "88 89 94 97 8c 8c"),  # again for the host, as it has not rested
        (0, 0x58, ""),  # a message waits for a host
    ],
)
def test_a_board_is_asked_before_its_host(moving, idle, asked):
    heard, relayed = [], []
    answers = {0x8C: bytes([0x8C, moving]) + bytes(14)}

    async def bridge(reader, writer):
        code, status = 0, idle
        while line := (await reader.readline()).decode().split():
            heard.append(" ".join(line))
            if line[:2] == ["w", "0"]:
                code = int(line[2], 16)
            elif line[:2] == ["w", "1"]:
                status = 0x58 if line[2] == "10" else idle
            answer = answers.get(code, bytes([code, *bytes(15)])).hex(" ")
            answer = "ok" if line[0] == "w" else f"{status:02x}" if line == ["r", "1"] else answer
            writer.write(answer.encode() + b"\n")
        writer.close()
        heard.append("end")

    async def talk():
        board = await asyncio.start_server(bridge, "127.0.0.1", 0)
        url = parse(f"bus://127.0.0.1:{board.sockets[0].getsockname()[1]}")
        asker = BoardAsker(questions_of(product("1811")), lambda by_host, data: relayed.append((by_host, data)))
        relay = BusRelay(url, asker.tell, asker)
        port = await relay.open(parse("bus://127.0.0.1:0"))
        reader, writer = await asyncio.open_connection(port.host, port.port)
        writer.write(b"r 1\n")
        answer = await reader.readline()
        writer.close()
        await writer.wait_closed()
        while relay.busy or heard.count("end") < 2:
            await asyncio.sleep(0)
        relay.close()
        board.close()
        return answer

    assert asyncio.run(talk()) == b"%x\n" % idle
    assert [line.removeprefix("w 0 ") for line in heard if line.startswith("w 0")] == asked.split()
    assert sum(by_host for by_host, _ in relayed) == len(heard) - 2  # the twin hears it all
