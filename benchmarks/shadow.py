"""Prove that `axistwin shadow` finds wear, and finds nothing where there is none.

    python benchmarks/shadow.py [plants|quiet|long|ports|hosts] [--hours 24] [--days 30] [--seed 1] [--only N]

A second bench is the real machine.  `plants`: forty signs of wear, each of which must be found within three
occurrences, after the shadow has learnt the healthy machine.  `quiet`: ordinary work with a jitter of 3 ms, and acts of
people, without a finding.  `long`: the memory of a shadow over many days, at 100 requests a minute.  `ports` and
`hosts`: see `shadow_ports.py` and `shadow_hosts.py`.  All but `hosts` is in virtual time.  The exit code is 1 if a goal
is missed.
"""

import argparse
import gc
import random
import resource
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin.bench import Bench
from axistwin.core.units import MS, S
from axistwin.devices import load
from axistwin.plant.encoder import EncoderData
from axistwin.real.shadow.findings import Finding, Kind
from axistwin.real.shadow.log import Log
from axistwin.real.shadow.shadow import Shadow
from axistwin.real.shadow.twin import Twin

EPOCH_NS = 1_800_000_000 * S
FAR = 1 << 40
JITTER_NS = 3 * MS
ESP300 = Path(__file__).resolve().parents[1] / "examples" / "devices" / "esp300.py"
AXES = {"if1": ("X", "Y", "Z"), "1811": ("motor",), "smartmotor": ("shaft",), "esp300": ("1", "2", "3")}
GOAL, OF = 38, 40
POLL_S = 0.02
LEARNING = 18  # Times that everything is done before the wear.

Filter = Callable[[bytes], bytes]


def bench_of(model: str, **options: Any) -> Bench:
    """Return a bench with one controller whose limit switches are closed, half a minute after power-up."""
    load(ESP300)
    bench = Bench()
    axes = {axis: {"limits": (-FAR, FAR)} for axis in AXES[model]}
    for axis in axes.keys() & options.keys():
        options[axis] = axes[axis] | options[axis]
    bench.add(model, history=50, **(axes | options))
    bench.run(2)
    return bench


class Rig:
    """A host at a machine, with its shadow; all in virtual time.  `ppm`: the machine's clock against the host's."""

    def __init__(
        self, model: str, machine: Bench | None = None, twin: Bench | None = None, *, jitter_ns: int = JITTER_NS,
        seed: int = 1, ppm: int = 0, **settings: Any,
    ) -> None:  # fmt: skip
        machine, twin = machine or bench_of(model), twin or bench_of(model)
        self.model, self.bench, self._ppm = model, machine, ppm
        self.machine = Twin(machine, next(iter(machine.controllers)))
        self.controller = self.machine.controller
        self.machine.heard = self._said
        self.found: list[Finding] = []
        self.shadow = Shadow(Twin(twin, next(iter(twin.controllers))), self.found.append, **settings)
        self._begun_ns, self._jitter_ns, self._random = machine.now, jitter_ns, random.Random(seed)
        self._under_way: deque[tuple[int, bytes]] = deque()
        self.received = bytearray()
        self.to_machine: Filter = lambda data: data
        self.to_host: Filter = lambda data: data
        self.delay_ns = self._late_ns = 0

    @property
    def now(self) -> int:
        return self._host_ns(self.bench.now)

    def _host_ns(self, machine_ns: int) -> int:
        """Return the time of the host's clock at a time of the machine's."""
        return EPOCH_NS + (machine_ns - self._begun_ns) * 1_000_000 // (1_000_000 + self._ppm)

    def _machine_ns(self, host_ns: int) -> int:
        return self._begun_ns + -((EPOCH_NS - host_ns) * (1_000_000 + self._ppm) // 1_000_000)

    def _said(self, time_ns: int, data: bytes) -> None:
        at_ns = self._host_ns(time_ns) + self.delay_ns + self._late_ns
        if self._under_way:
            at_ns = max(at_ns, self._under_way[-1][0])
        if data := self.to_host(data):
            self._under_way.append((at_ns, data))

    def say(self, data: bytes) -> None:
        """Send data, to the machine and past its shadow."""
        self._late_ns = self._random.randrange(self._jitter_ns + 1)
        self.shadow.host(self.now, data)
        if sent := self.to_machine(data):
            self.machine.write(sent)

    def run(self, seconds: float) -> None:
        self._run_until(self.bench.now + round(seconds * S))

    def _run_until(self, end_ns: int, enough: Callable[[], bool] = lambda: False) -> None:
        clock = self.bench.clock
        while not enough():
            due_ns = clock.next_event_ns()
            arriving_ns = self._machine_ns(self._under_way[0][0]) if self._under_way else end_ns + 1
            if arriving_ns <= end_ns and (due_ns is None or arriving_ns <= due_ns):
                if arriving_ns > clock.now:
                    clock.run_to(arriving_ns)
                at_ns, data = self._under_way.popleft()
                self.shadow.machine(max(at_ns, self.now), data)
                self.received += data
            elif due_ns is None or due_ns > end_ns:
                clock.run_to(end_ns)
                self.shadow.tick(self.now)
                return
            else:
                clock.step()

    def ask(self, data: bytes, timeout: float = 0.5) -> bytes:
        """Send a request, and return the answer; b"" without one."""
        self.received.clear()
        if self.machine.on_bus and not self.controller.powered:  # The host reads FF on the bus, and sends nothing.
            self.shadow.absent(self.now)
            self.run(timeout)
            return b""
        self.say(data)
        size = 16 if self.model == "1811" else 0

        def whole() -> bool:
            return len(self.received) >= size if size else self.received.endswith((b"\r", b"\n"))

        self._run_until(self.bench.now + round(timeout * S), whole)
        return bytes(self.received)

    def describe_limit(self, axis: str, direction: int, position: int) -> None:
        """Place a limit switch that the twin's scene has, too."""
        for stage in (self.machine, self.shadow.twin):
            stage.set_limit(axis, direction, position)

    def differences(self) -> list[Finding]:
        return [found for found in self.found if found.kind is not Kind.NOTE]


class Work:
    """What a host does all day, over and over: `cycle` is one occurrence of everything."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig

    def begin(self) -> None: ...

    def cycle(self) -> None: ...

    def home(self) -> None:
        """Go to position 0, as `cycle` does at its end."""

    def until_at_rest(self, rests: Callable[[], bool], then_s: float) -> None:
        """Ask again and again whether the motor rests, then wait."""
        for _ in range(400):
            self.rig.run(POLL_S)
            if rests():
                break
        self.rig.run(then_s)


class DigiplanWork(Work):
    """An IF1 moves to and fro, and once against its limit switch."""

    HOME = -9000

    def begin(self) -> None:
        rig = self.rig
        rig.machine.set_limit("X", -1, self.HOME)
        rig.ask(b"(")
        rig.say(b"U61\r")
        rig.run(1.3)
        rig.say(b">1<4^20@12000\r")
        rig.run(1.2)

    def move(self, text: bytes) -> None:
        rig = self.rig
        rig.say(text)
        for _ in range(400):
            if rig.ask(b"E\r") in (b"C\r", b"F\r"):
                break
            rig.run(POLL_S)
        while int(rig.ask(b"K\r") or b"0") & 1:
            rig.run(POLL_S)
        for request in (b"N\r", b"K\r", b"F\r", b"I\r"):
            rig.ask(request)

    def cycle(self) -> None:
        rig = self.rig
        for text in (b"X24000$\r", b"X-24000$\r", b"X-27000$\r"):
            self.move(text)
        self.home()
        rig.say(b"@3000\r")
        rig.say(b"@12000\r")

    def home(self) -> None:
        if steps := -self.rig.machine.position("X"):
            self.move(b"X%d$\r" % steps)


class BoardWork(Work):
    """An 1811 with an encoder moves to and fro; its host polls 8Ch and 88h."""

    OPTIONS: ClassVar[dict[str, Any]] = {"motor": {"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25_000}}}

    def begin(self) -> None:
        rig = self.rig
        rig.machine.set_limit("motor", -1, -35_000)
        rig.say(bytes.fromhex("31 00 00 00 00 61 A8 00 00 61 A8"))
        rig.run(0.1)

    def move(self, command: bytes) -> None:
        self.rig.say(command)
        self.until_at_rest(lambda: self.rig.ask(b"\x8c")[1:2] == b"\0", 0.2)
        for request in (b"\x83", b"\x80", b"\x88", b"\x89", b"\x9a", b"\x94", b"\x97"):
            self.rig.ask(request)

    def cycle(self) -> None:
        for distance in (60_000, -60_000, -40_000):
            self.move(b"\x33" + distance.to_bytes(4, "big", signed=True))
        self.home()

    def home(self) -> None:
        back = -self.rig.machine.position("motor")
        self.move(b"\x33" + back.to_bytes(4, "big", signed=True))


class MotorWork(Work):
    """A SmartMotor moves to and fro; its host polls RBt."""

    def begin(self) -> None:
        rig = self.rig
        rig.machine.set_limit("shaft", -1, -25_000)
        rig.say(b"ZS A=200 V=1000000 MP ")
        rig.run(0.2)

    def move(self, text: bytes) -> None:
        self.rig.say(text)
        self.until_at_rest(lambda: self.rig.ask(b"RBt\r") == b"0\r", 0.1)
        for request in (b"RP\r", b"RW\r", b"RPE\r", b"Ra\r", b"RMODE\r"):
            self.rig.ask(request)

    def cycle(self) -> None:
        rig = self.rig
        for text in (b"ZS P=40000 G ", b"P=0 G ", b"P=-30000 G ", b"ZS P=0 G "):
            self.move(text)
        rig.say(b"a=a+1\r")

    def home(self) -> None:
        self.move(b"ZS P=0 G ")


class StageWork(Work):
    """An ESP300-like stage moves to and fro, and against its limit, which its twin knows; its host polls MD."""

    def begin(self) -> None:
        self.rig.describe_limit("1", -1, -20_000)
        self.rig.say(b"1MO;1VA10;1AC10;1AG10\r")
        self.rig.run(0.1)

    def move(self, text: bytes) -> None:
        self.rig.say(text)
        self.until_at_rest(lambda: self.rig.ask(b"1MD?\r") == b"1\r\n", 0.1)
        for request in (b"1TP\r", b"1TV?\r", b"TE?\r", b"TS\r", b"1AC?\r", b"VE?\r"):
            self.rig.ask(request)

    def cycle(self) -> None:
        for text in (b"1PA12.5\r", b"1PR-20\r", b"1PA-30\r"):
            self.move(text)
        self.home()

    def home(self) -> None:
        self.move(b"1PA0\r")


WORK: dict[str, type[Work]] = {"if1": DigiplanWork, "1811": BoardWork, "smartmotor": MotorWork, "esp300": StageWork}


@dataclass(frozen=True)
class Plant:
    """One sign of wear: how it is planted, and the kinds of findings that name it."""

    model: str
    name: str
    plant: Callable[[Rig], object]
    kinds: tuple[Kind, ...]
    options: dict[str, Any] = field(default_factory=dict)  # Of both, before the wear.


def replacing(old: bytes, new: bytes) -> Filter:
    return lambda data: data.replace(old, new)


def answers(change: Filter) -> Callable[[Rig], object]:
    return lambda rig: setattr(rig, "to_host", change)


def requests(old: bytes, new: bytes) -> Callable[[Rig], object]:
    def plant(rig: Rig) -> None:
        rig.to_machine = replacing(old, new)

    return plant


def once(at: int, change: Filter) -> Filter:
    """Change the `at`-th piece of data, and those 200 and 400 later."""
    count = 0

    def changed(data: bytes) -> bytes:
        nonlocal count
        count += 1
        return change(data) if count % 200 == at else data

    return changed


def flip(data: bytes) -> bytes:
    return bytes((data[0] ^ 0x02,)) + data[1:]


def flip_message(data: bytes) -> bytes:
    return data[:1] + bytes((data[1] ^ 0x02,)) + data[2:]


def stuck(data: bytes) -> bytes:
    return data[:1] + b"\x03" + data[2:] if data[0] == 0x97 else data


def newer(data: bytes) -> bytes:
    return data[:15] + b"\x01" if data[0] == 0x88 else data


def late(rig: Rig) -> None:
    rig.delay_ns = 40 * MS


def fault(sentence: str, *target: str, **parameters: Any) -> Callable[[Rig], object]:
    return lambda rig: rig.bench.faults.add(sentence, *target, **parameters)


def limit_at(axis: str, position: int, direction: int = -1) -> Callable[[Rig], object]:
    return lambda rig: rig.machine.set_limit(axis, direction, position)


ENCODER = {"counts_per_rev": 4000, "pulses_per_rev": 25_000}
COUNTED, SLOW = (Kind.COUNT, Kind.ANSWER), (Kind.DURATION,)
GARBLED = (Kind.ANSWER, Kind.CHARACTERS, Kind.MISSING, Kind.SURPLUS, Kind.COUNT, Kind.FAULT)
TORQUE = {"motor": {"torque": [[0, 1.0], [40_000, 0.8]]}, "load": {"torque": 0.1}}


def lost_request(rig: Rig) -> None:
    rig.to_machine = once(30, lambda data: data[:-1])


def lose_message(rig: Rig) -> None:
    rig.to_host = once(30, lambda data: b"")


def backlash(rig: Rig) -> None:
    rig.controller.axes["motor"]._encoder._encoder.data = EncoderData(**ENCODER, backlash=40)


def slip(counts: int) -> Callable[[Rig], object]:
    return lambda rig: rig.controller.axes["motor"]._encoder.slip(counts)


def weak(rig: Rig) -> None:
    rig.bench.faults.add("stall", f"{rig.controller.name}.motor", left=0.1)


def renew_ramp(rig: Rig) -> None:
    """The machine calculates its ramps 5 % slower from now on."""
    rig.to_machine = replacing(b"^20", b"^19")
    rig.machine.write(b"^19\r")
    rig.run(1.3)


def slower_board(rig: Rig) -> None:
    rig.machine.write(bytes.fromhex("31 00 00 00 00 61 A8 00 00 5C C1"))
    rig.run(0.1)


def slower_motor(rig: Rig) -> None:
    rig.machine.write(b"A=190 ")
    rig.run(0.1)


def slower_stage(rig: Rig) -> None:
    rig.machine.write(b"1AC9.5;1AG9.5\r")
    rig.run(0.1)


def parity_fault(rig: Rig) -> None:
    """A damaged character reaches the interface now and then."""
    rig.to_machine = once(33, lambda data: b"~" + data)


PLANTS = (
    Plant("if1", "ramp 5 % slower", renew_ramp, SLOW),
    Plant("if1", "backlash of 30 pulses at the limit", limit_at("X", -9030), COUNTED),
    Plant("if1", "100 lost steps", limit_at("X", -8900), COUNTED),
    Plant("if1", "answers 40 ms late", late, (Kind.LATE,)),
    Plant("if1", "a flipped bit", answers(once(30, flip)), GARBLED),
    Plant("if1", "limit 50 pulses early", limit_at("X", -8950), COUNTED),
    Plant("if1", "weak motor, 900 steps lost", limit_at("X", -8100), COUNTED),
    Plant("if1", "a lost character", answers(once(31, lambda data: b"")), GARBLED),
    Plant("if1", "a fault bit", parity_fault, (*GARBLED, Kind.FAULT)),
    Plant("if1", "another firmware's answer", answers(replacing(b"C", b"c")), (Kind.ANSWER,)),
    Plant("1811", "ramp 5 % slower", slower_board, SLOW),
    Plant("1811", "backlash of 40 counts", backlash, COUNTED),
    Plant("1811", "lost steps, seen by the encoder", slip(-60), COUNTED),
    Plant("1811", "answers 40 ms late", late, (Kind.LATE,)),
    Plant("1811", "a flipped bit", answers(once(30, flip_message)), GARBLED),
    Plant("1811", "limit 50 pulses early", limit_at("motor", -34_950), COUNTED),
    Plant("1811", "weak motor", weak, COUNTED, TORQUE),
    Plant("1811", "a lost message", lose_message, (Kind.MISSING,)),
    Plant("1811", "a stuck output bit", answers(stuck), (Kind.ANSWER,)),
    Plant("1811", "another firmware's answer", answers(newer), GARBLED),
    Plant("smartmotor", "ramp 5 % slower", slower_motor, SLOW),
    Plant("smartmotor", "backlash of 30 counts at the limit", limit_at("shaft", -25_030), COUNTED),
    Plant("smartmotor", "100 lost counts", limit_at("shaft", -24_900), COUNTED),
    Plant("smartmotor", "answers 40 ms late", late, (Kind.LATE,)),
    Plant("smartmotor", "a flipped bit", answers(once(30, flip)), GARBLED),
    Plant("smartmotor", "limit 50 counts early", limit_at("shaft", -24_950), COUNTED),
    Plant("smartmotor", "a fault bit: overheat", fault("overheat", "smartmotor"), (Kind.FAULT,)),
    Plant("smartmotor", "a lost character", answers(once(31, lambda data: b"")), GARBLED),
    Plant("smartmotor", "a lost character of a request", lost_request, GARBLED),
    Plant("smartmotor", "another firmware's answer", answers(replacing(b"P", b"A")), (Kind.ANSWER,)),
    Plant("esp300", "ramp 5 % slower", slower_stage, SLOW),
    Plant("esp300", "backlash of 30 counts at the limit", limit_at("1", -20_030), COUNTED),
    Plant("esp300", "100 lost counts", limit_at("1", -19_900), COUNTED),
    Plant("esp300", "answers 40 ms late", late, (Kind.LATE,)),
    Plant("esp300", "a flipped bit", answers(once(30, flip)), GARBLED),
    Plant("esp300", "limit 50 counts early", limit_at("1", -19_950), COUNTED),
    Plant("esp300", "a status bit that is stuck", answers(replacing(b"P", b"T")), (Kind.ANSWER,)),
    Plant("esp300", "a lost character", answers(once(31, lambda data: b"")), GARBLED),
    Plant("esp300", "a lost character of a request", lost_request, GARBLED),
    Plant("esp300", "another firmware's answer", answers(replacing(b"V", b"v")), (Kind.ANSWER,)),
)  # fmt: skip


def tried(
    plant: Plant, seed: int = 1, learning: int = LEARNING, occurrences: int = 3, make: Callable[..., Rig] = Rig
) -> tuple[list[Finding], list[Finding]]:
    """Return what was found before the plant, and within three occurrences of it."""
    options = getattr(WORK[plant.model], "OPTIONS", {})
    if plant.options:
        options = {axis: {**given, **plant.options} for axis, given in options.items()}
    rig = make(plant.model, bench_of(plant.model, **options), bench_of(plant.model, **options), seed=seed)
    work = WORK[plant.model](rig)
    work.begin()
    for _ in range(learning):
        work.cycle()
    rig.run(3)
    before = rig.differences()
    plant.plant(rig)
    for _ in range(occurrences):
        work.cycle()
    rig.run(3)
    return before, rig.differences()[len(before) :]


def verdict(plant: Plant, before: list[Finding], found: list[Finding]) -> str:
    if before:
        return f"FALSE     {before[0].line()[25:]}"
    named = [finding for finding in found if finding.kind in plant.kinds]
    words = "; ".join(finding.line()[25:] for finding in named[:1] or found) or "nothing"
    return f"{'found' if named else 'NOT FOUND':9} {words}"


def plants(seed: int, only: str) -> bool:
    """Plant each sign of wear; print what was found."""
    chosen = [plant for plant in PLANTS if only in f"{plant.model} {plant.name}"]
    good = 0
    for plant in chosen:
        words = verdict(plant, *tried(plant, seed))
        good += words.startswith("found")
        print(f"{plant.model:10} {plant.name:36} {words}", flush=True)
    print(f"{good} of {len(chosen)} found within three occurrences (goal: {GOAL} of {OF})")
    return good * OF >= GOAL * len(chosen)


class People:
    """What people do at a machine: stops, switches, joystick, the power, a push at the shaft."""

    def __init__(self, work: Work, seed: int) -> None:
        self.work, self.rig, self.random = work, work.rig, random.Random(seed)

    def act(self) -> str:
        acts = [name for name in dir(self) if name.startswith((f"_{WORD[self.rig.model]}_", "_any_"))]
        chosen: str = self.random.choice(acts)
        getattr(self, chosen)()
        return chosen.strip("_")

    def _any_power(self) -> None:
        rig = self.rig
        rig.controller.power(False)
        for _ in range(self.random.randrange(4, 12)):
            rig.ask(POLL[rig.model], timeout=0.8)
            rig.run(0.5)
        rig.controller.power(True)
        rig.run(2.5)
        self.work.begin()

    def _any_pause(self) -> None:
        self.rig.run(self.random.randrange(60, 1800))

    def _if1_stop(self) -> None:
        rig = self.rig
        rig.say(b"X9000$\r")
        rig.run(self.random.uniform(0.2, 0.8))
        rig.controller.pins["estop"].drive(False)
        self.settle()
        rig.run(1)
        rig.ask(b"K\r")
        rig.controller.pins["estop"].drive(True)
        rig.run(0.5)
        rig.ask(b"K\r")
        rig.ask(b"E\r")
        self.work.home()

    def _if1_switch(self) -> None:
        pin = self.rig.controller.pins[self.random.choice(("input1", "input2", "input3"))]
        pin.drive(not pin.level)
        self.rig.ask(b"I\r")

    def settle(self) -> None:
        for _ in range(200):
            if self.rig.ask(b"E\r") in (b"F\r", b"C\r") and not int(self.rig.ask(b"K\r") or b"0") & 1:
                return
            self.rig.run(POLL_S)

    def _board_joystick(self) -> None:
        rig = self.rig
        rig.say(b"\x11")
        rig.run(0.2)
        rig.controller.joystick.deflect(self.random.choice((-1, 1)) * self.random.randrange(200, 900))
        for _ in range(20):
            rig.run(0.1)
            rig.ask(b"\x83")
            rig.ask(b"\x8c")
        rig.controller.joystick.deflect(0)
        rig.run(1)
        rig.ask(b"\x83")
        rig.say(b"\x10")
        rig.run(0.5)
        rig.ask(b"\x83")
        self.work.home()

    def _board_trigger(self) -> None:
        pin = self.rig.controller.pins[f"trigger{self.random.randrange(2, 6)}"]
        pin.drive(not pin.level)
        self.rig.run(0.1)
        self.rig.ask(b"\x94")

    def _motor_push(self) -> None:
        rig = self.rig
        rig.say(b"OFF ")
        rig.run(0.3)
        rig.ask(b"RW\r")
        rig.controller.axes["shaft"].encoder.displace(self.random.randrange(-900, 900))
        rig.run(0.2)
        rig.ask(b"RP\r")
        rig.say(b"ZS P=0 G ")
        self.work.home()

    def _motor_stop(self) -> None:
        rig = self.rig
        rig.say(b"P=30000 G ")
        rig.run(self.random.uniform(0.3, 0.9))
        rig.say(b"X ")
        rig.run(1)
        rig.ask(b"RBt\r")
        self.work.home()

    def _stage_stop(self) -> None:
        rig = self.rig
        rig.say(b"1PA12.5\r")
        rig.run(self.random.uniform(0.3, 1.5))
        rig.say(b"1ST\r")
        rig.run(1.5)
        rig.ask(b"1TP\r")
        self.work.home()

    def _stage_switch(self) -> None:
        """Somebody presses the limit switch, which stops the axis with an error."""
        rig = self.rig
        rig.say(b"1PA12.5\r")
        rig.run(self.random.uniform(0.3, 1.5))
        pin = rig.controller.pins["plus1"]
        pin.drive(False)
        rig.run(0.5)
        pin.drive(True)
        for request in (b"1MD?\r", b"TE?\r", b"1TP\r"):
            rig.ask(request)
        self.work.home()


WORD = {"if1": "if1", "1811": "board", "smartmotor": "motor", "esp300": "stage"}
POLL = {"if1": b"E\r", "1811": b"\x8c", "smartmotor": b"RBt\r", "esp300": b"1MD?\r"}


def day(
    model: str, hours: float, seed: int, pause_s: float = 20.0, **settings: Any
) -> tuple[Rig, list[str]]:  # fmt: skip
    """Work for some hours, with acts of people about every ten minutes; return the rig and the acts."""
    options = getattr(WORK[model], "OPTIONS", {})
    rig = Rig(model, bench_of(model, **options), bench_of(model, **options), seed=seed, **settings)
    work = WORK[model](rig)
    people, acts = People(work, seed), list[str]()
    work.begin()
    while rig.now - EPOCH_NS < hours * 3600 * S:
        work.cycle()
        rig.run(people.random.uniform(0, 2 * pause_s))
        if people.random.random() < 0.07:
            acts.append(people.act())
    return rig, acts


def quiet(hours: float, seed: int, only: str) -> bool:
    good = True
    for model in WORK:
        if only not in model:
            continue
        began = time.monotonic()
        rig, acts = day(model, hours, seed)
        found = rig.differences()
        good &= not found
        print(
            f"{model:10} {hours:g} h, {rig.shadow.pairs} answers, {len(acts)} acts of people: "
            f"{len(found)} false findings, {len(rig.found) - len(found)} notes ({time.monotonic() - began:.0f} s)",
            flush=True,
        )
        for finding in found:
            print("   ", finding.line(), f"{finding.count} times")
    return good


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def long(days: int, per_minute: int = 100) -> bool:
    """Ask E all day, with a move every minute; print memory and disk, which must stay flat."""
    with tempfile.TemporaryDirectory() as folder:
        log = Log(Path(folder, "shadow.jsonl"), print)
        fast = {"line": "instant"}
        rig = Rig("if1", bench_of("if1", **fast), bench_of("if1", **fast), timed=log.timed)
        work = DigiplanWork(rig)
        work.begin()
        memory, began = list[int](), time.monotonic()
        for day_number in range(1, days + 1):
            for minute in range(24 * 60):
                rig.say(b"X2000$\r" if minute % 2 else b"X-2000$\r")
                for _ in range(per_minute):
                    rig.ask(b"E\r")
                    rig.run(60 / per_minute - 0.003)
                log.tick(rig.now, rig.shadow.learned)
            gc.collect()
            memory.append(resident_bytes())
            disk = sum(path.stat().st_size for path in Path(folder).iterdir())
            print(
                f"day {day_number}: {rig.shadow.pairs} answers, {memory[-1] / 1e6:.1f} MB, log {disk / 1e6:.2f} MB, "
                f"{len(rig.differences())} findings ({time.monotonic() - began:.0f} s)",
                flush=True,
            )
    changed = (max(memory[2:], default=0) - min(memory[2:], default=0)) / 2
    print(f"memory changes by ± {changed / 1e6:.2f} MB after the second day (goal: 2 MB)")
    return changed <= 2e6


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("what", nargs="?", choices=("plants", "quiet", "long", "ports", "hosts"), default="plants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--days", type=int, default=30)
    parser.add_argument("--hours", type=float, default=24.0)
    given = parser.parse_args()
    if given.what == "quiet":
        return 0 if quiet(given.hours, given.seed, given.only) else 1
    if given.what == "long":
        return 0 if long(given.days) else 1
    if given.what == "ports":
        import shadow_ports

        return 0 if shadow_ports.ports(given.seed, given.only) else 1
    if given.what == "hosts":
        import shadow_hosts

        return 0 if shadow_hosts.hosts(given.only) else 1
    return 0 if plants(given.seed, given.only) else 1


if __name__ == "__main__":
    sys.exit(main())
