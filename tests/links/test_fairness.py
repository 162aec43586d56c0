"""Data from one host do not delay other hosts; measured in clock steps between two turns of the event loop."""

import importlib.util
import sys
from functools import partial
from itertools import count
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.links import pacing
from axistwin.links.pacing import Pacer
from axistwin.links.plug import CHUNK, FEW, FULL, INSTANT_CHUNK, Plug

from .fake_loop import Loop

ROBUSTNESS = Path(__file__).resolve().parents[2] / "benchmarks" / "robustness"
STEPS = 20
"""Clock steps per slice; the fake wall clock advances by a fixed time per step."""


def campaign(name):
    """Return a script of the folder `benchmarks/robustness` as a module."""
    spec = importlib.util.spec_from_file_location(name, ROBUSTNESS / f"{name}.py")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


fuzz = campaign("fuzz")
fairness = campaign("fairness")


class Client:
    """A host that sends as much as is read from it."""

    name, flow = "a host", None

    def __init__(self):
        self.taken, self.pauses = True, 0

    def pause(self):
        self.taken, self.pauses = False, self.pauses + 1

    def resume(self):
        self.taken = True

    def deliver(self, data, errors):
        """Ignore the data."""

    def hung_up(self):
        return False


class Turns(Loop):
    """Counts the steps of a clock in each turn of the loop."""

    def __init__(self, clock):
        super().__init__()
        self.steps, self.most, self._step = 0, 0, clock.step
        clock.step = self._counted

    def _counted(self):
        self.steps += 1
        self._step()

    def turn(self, action):
        before = self.steps
        action()
        self.most = max(self.most, self.steps - before)

    def call_at(self, at_s, action):
        return super().call_at(at_s, lambda: self.turn(action))


@pytest.fixture
def slow_machine(monkeypatch):
    ticks = count()
    monkeypatch.setattr(pacing, "perf_counter", lambda: next(ticks) * pacing.SLICE_S / STEPS)


@pytest.mark.parametrize("name", list(fairness.ATTACKED))
def test_between_two_turns_of_the_loop_there_is_a_slice_at_most(slow_machine, name):
    for baudrate in (110, 9600, 115_200, 1_000_000, 4_000_000):
        target = fairness.ATTACKED[name]()
        target.bench.clock.patient = False
        loop = Turns(target.bench.clock)
        pacer = Pacer(target.bench.clock, 1.0)
        pacer.start(loop)
        plug = Plug(target.name, target.port, pacer)
        plug.connect(Client())
        target.port.host.baudrate = baudrate
        for number in range(3):
            loop.now_s += 0.01
            loop.turn(partial(plug.send, fuzz.garbage(number, 100)))
            loop.run_to(loop.now_s)
        assert loop.steps > 0
        assert loop.most <= 2 * (STEPS + 5), baudrate  # once to bring time up to now, once for the events that are due


def test_a_host_that_sends_more_than_can_be_computed_is_not_read_from_until_it_has_been(slow_machine):
    """At 4 Mbaud 512 characters last 1.28 ms, but need more than 512 steps, that is 26 slices of 2 ms here."""
    target = fuzz.PORTS["if1"]()
    loop = Turns(target.bench.clock)
    pacer = Pacer(target.bench.clock, 1.0)
    pacer.start(loop)
    plug, client = Plug(target.name, target.port, pacer), Client()
    plug.connect(client)
    target.port.host.baudrate = 4_000_000
    longest_s = 0.0
    for _ in range(200):
        loop.now_s += pacing.SLICE_S
        if client.taken:
            plug.send(bytes(CHUNK))
        loop.run_to(loop.now_s)
        longest_s = max(longest_s, pacer.behind_s)
    assert client.pauses > 2
    assert longest_s < 0.060  # it would be 1 s if data were read as fast as the wire transmits
    assert target.port.pending <= FULL


def test_a_bench_that_keeps_pace_is_not_behind():
    target = fuzz.PORTS["if1"]()
    loop = Loop()
    pacer = Pacer(target.bench.clock, 1.0)
    assert pacer.behind_s == 0
    pacer.start(loop)
    plug, client = Plug(target.name, target.port, pacer), Client()
    plug.connect(client)
    plug.send(bytes(FEW + 1))
    loop.run_to(1)
    assert (pacer.behind_s, client.pauses) == (0, 0)


@pytest.mark.parametrize(("line", "chunk"), [("9600 8N2", CHUNK), ("instant", INSTANT_CHUNK)])
def test_on_a_line_that_takes_no_time_less_is_taken_at_once(line, chunk):
    bench = Bench()
    assert Plug("if1", bench.add("if1", line=line).serial, Pacer(bench.clock)).chunk == chunk


@pytest.mark.parametrize("name", list(fuzz.PORTS))
def test_a_small_fuzz_campaign_is_the_same_every_time_and_raises_nothing(name):
    for baudrate in (110, 9600, 115_200, 4_000_000):
        outcomes = [fuzz.attack(fuzz.PORTS[name](), baudrate, fuzz.garbage(fuzz.SEED, 60)) for _ in range(2)]
        assert [outcome.error for outcome in outcomes] == [None, None]
        first, second = [(outcome.carried, outcome.found) for outcome in outcomes]
        assert first == second
        assert first[1] <= 5 * first[0]  # a frame has at most five falling edges


@pytest.mark.parametrize("model", ["1810", "1811"])
def test_random_bytes_in_the_registers_of_a_board(model):
    assert fuzz.attack_board(model, fuzz.SEED, 200).error is None
