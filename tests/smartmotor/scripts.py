"""Scripts of what is said to a SmartMotor, what its shaft and pins do, and what it answers."""

import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim.serial_port import SerialPort

from . import scenarios, talking
from .bits import BITS

MOTORS = {"bare": talking.bare, "wired": talking.wired, "with": talking.ready}
LIKE_AN_ACT = re.compile(r"(?:^| )(?:[a-z]{4,}|is|low|at)(?: |$)")
"""Words of scripts, not of the language; otherwise an act with a mistake would be sent and ignored."""
CODES = {"SP": " ", "CR": "\r", "LF": "\n"}


def scripts(table: Mapping[str, str | Sequence[str]]) -> pytest.MarkDecorator:
    """Parametrise a test by scripts for `play`, or by lists of scripts; each key is a section with its rule."""
    return pytest.mark.parametrize("script", table.values(), ids=table.keys())


def play(script: str | Sequence[str]) -> None:
    """Carry out the actions and checks of a script, which are separated by `; `, or each script of a list.

    A script may begin with its motor: `with frame23`, `with statements_per_sample=2 limits=-500,500` (options), `wired`
    (closed limit switches on C and D), `bare` (its faults not cleared), `new` (no time has passed), `line 9600 8N1`;
    otherwise it begins with a motor without faults, at a whole sample.
    Said to the motor, in no time: `P=5 G` (a line, which is not answered), `RP Ra -> 5 0` (its answers, each with CR),
    `PRINT(1) => 1` (exactly these characters), `RUN -> 5 in 0.1 s` (all that comes until then), `G -> *` (any),
    `sends a=1<SP>` (characters without CR; they may be answered too), `485: RP -> 0` (channel 1), `load a=1 / END`
    (download; ` / ` is a new line), `run a=1 / END` (and start it, for 100 samples), `writes RP<CR>` and
    `485 writes RP<CR>` (the answers are left to `receives 0<CR>`, `receives nothing`, `485 receives 0<CR>`).
    `<CR>`, `<LF>`, `<SP>` and codes such as `<06>` are characters.
    Time: `3 samples` (to the third whole one), `0.1 s`.
    Done to it: `G low`, `C high`, `C released`, `C 2.5 V`, `trigger` (G low and high, 20 samples each), `push 50`,
    `jam`, `free`, `torque 0.1`, `master 400 in 0.5 s`, `master 400 in 20 samples`, `turn 0 500: 0 125` (the external
    encoder, to counts; the shaft's positions there), `turn 5 by 1` (counts per sample), `power off`, `power on`,
    `power cycle`, `clear` (the faults of power-up), `air 71` (°C), `pins 90` (all seven), `dip 0.2 0.05` (the supply,
    for seconds), `mend`, `host parity E`, `flip 1`, `break 0.01 s`.
    Checks: `at 500`, `at > 5`, `commanded 500` (the shaft), `still`, `positions 1 3 6` (in the next samples), `steps
    1 2 3`, `20 steps of -10` (counts in each), `mark`, and then `moved 30` or `onwards 1 3 6` (counts since), `a is 5`,
    `a > 5`, `a != 5` (an expression), `keep a`, and then `a kept`, `a grew`, `a grew by 5`, `C is low`, `C is 5.0 V`,
    `C is output`, `W orp` (the bits of the status word, without Bi, or their sum), `Bits orp` (all bits, in the order
    trliwehoxpmdusak, and that all reports of the status agree), `watch C`, and then `C unchanged` or `C went low @0
    high @8` (samples since), `line 2`, `no line`, `watch lines`, and then `lines 1 2` or `lines 1@1 2@2` (those that
    have begun, and when), `lists a=1 / END` (the stored program).
    """
    for one in [script] if isinstance(script, str) else script:
        bench, motor, acts = _begun(one.split("; "))
        kept = Kept(motor)
        for act in acts:
            answered = " -> " in act or " => " in act
            if answered or not (kept.compares(act) or _happens(bench, motor, act) or _holds(bench, motor, act)):
                _say(bench, motor, act)


class Kept:
    """What later acts of a script are compared with."""

    def __init__(self, motor: Controller) -> None:
        self.bench, self.motor = motor.bench, motor
        self.marked = motor.axes["shaft"].position
        self.values: dict[str, int] = {}
        self.changes: dict[str, list[tuple[float, bool]]] = {}
        self.lines: list[tuple[float, int]] = []

    def compares(self, act: str) -> bool:
        """Keep something, or compare with it; return False if the act is neither."""
        shaft, found, expected = self.motor.axes["shaft"], None, None
        match act.split():
            case ["mark"]:
                self.marked = shaft.position
            case ["moved", counts]:
                found, expected = shaft.position - self.marked, int(counts)
            case ["onwards", *counts]:
                places = talking.positions(self.bench, self.motor, len(counts))
                found, expected = [place - self.marked for place in places], [int(number) for number in counts]
            case ["keep", name]:
                self.values[name] = talking.value(self.bench, self.motor, name)
            case [name, "kept" | "grew" as how] if name in self.values:
                now = talking.value(self.bench, self.motor, name)
                found, expected = now > self.values[name], how == "grew"
                assert how == "grew" or now == self.values[name], act
            case [name, "grew", "by", number]:
                found, expected = talking.value(self.bench, self.motor, name) - self.values[name], int(number)
            case ["watch", "lines"]:
                self.lines = []
                zero = self.bench.now

                def begins(program: str, n: int) -> None:
                    assert self.motor.registers["line"].read() == n + 1
                    self.lines.append((self._samples(zero), n + 1))

                self.motor.subscribe_lines(begins)
            case ["lines", *lines]:
                found = [f"{line}@{at:g}" if "@" in act else str(line) for at, line in self.lines]
                expected = lines
            case ["watch", pin]:
                self.changes[pin] = []
                zero = self.bench.now
                self.motor.pins[pin].subscribe(lambda p: self.changes[pin].append((self._samples(zero), bool(p.level))))
            case [pin, "went", *changes]:
                words = [("high" if level else "low", f"{at:g}") for at, level in self.changes[pin]]
                found = [word for pair in words for word in (pair if "@" in act else pair[:1])]
                expected = [word.lstrip("@") for word in changes]
            case [pin, "unchanged"]:
                found, expected = self.changes[pin], []
            case _:
                return False
        assert found == expected, f"{act}: {found}"
        return True

    def _samples(self, since_ns: int) -> float:
        return (self.bench.now - since_ns) / talking.SAMPLE_NS


def _begun(acts: list[str]) -> tuple[Bench, Controller, list[str]]:
    """Return a bench with the motor that the first act names, and the other acts."""
    bench = Bench()
    kind, _, options = acts[0].partition(" ")
    if kind in MOTORS:
        motor, acts = MOTORS[kind](bench, **_options(options)), acts[1:]
    elif kind == "line":
        return bench, talking.clear(bench, bench.add("smartmotor", line=options)), acts[1:]
    elif kind == "new":
        return bench, bench.add("smartmotor", line="instant"), acts[1:]
    else:
        motor = talking.ready(bench)
    talking.advance(bench)
    return bench, motor, acts


def _options(text: str) -> dict[str, Any]:
    options: dict[str, Any] = {}
    for name, _, value in (word.partition("=") for word in text.split()):
        if name == "limits":
            options.setdefault("shaft", {})[name] = tuple(map(int, value.split(",")))
        elif not value:
            options.setdefault("shaft", {})["motor"] = name
        else:
            options[name] = (
                int(value) if value.isdecimal() else value == "true" if value in ("true", "false") else value
            )
    return options


def _characters(text: str) -> str:
    return re.sub(r"<([0-9A-Z]{2})>", lambda m: CODES.get(m[1]) or chr(int(m[1], 16)), text)


def _say(bench: Bench, motor: Controller, act: str) -> None:
    port: Controller | SerialPort = motor
    if act.startswith("485: "):
        port, act = motor.rs485, act[5:]
    said, arrow, expected = act.partition(" => ")
    if not arrow:
        said, arrow, expected = act.partition(" -> ")
    seconds = 0.0
    if arrow and (last := re.fullmatch(r"(.*?) ?\bin ([\d.e-]+) s", expected, re.DOTALL)):
        expected, seconds = last[1], float(last[2])
    raw = said.startswith("sends ")
    assert raw or not LIKE_AN_ACT.search(said), f"neither an action nor a check: {act!r}"
    found = talking.send(bench, port, _characters(said[6:]).encode("latin-1") if raw else said, seconds)
    if arrow == " -> " and expected != "*":
        expected = "".join(word + "\r" for word in expected.split())
    if "*" in expected:
        assert fnmatchcase(found.decode("latin-1"), _characters(expected)), f"{act}: {found!r}"
    else:
        assert found == _characters(expected).encode("latin-1"), f"{act}: {found!r}"


def _happens(bench: Bench, motor: Controller, act: str) -> bool:
    """Perform an action other than a line; return False if it is none."""
    shaft, host = motor.axes["shaft"], motor.serial.host
    match act.split():
        case [number, "sample" | "samples"]:
            talking.advance(bench, int(number))
        case [seconds, "s"]:
            bench.run(float(seconds))
        case [pin, "low" | "high" as level]:
            motor.pins[pin].drive(level == "high")
        case [pin, "released"]:
            motor.pins[pin].release()
        case [pin, volts, "V"]:
            motor.pins[pin].drive(float(volts))
        case ["trigger"]:
            scenarios.trigger(bench, motor)
        case ["push", counts]:
            shaft.encoder.displace(int(counts))
        case ["jam" | "free" as what]:
            shaft.jam(what == "jam")
        case ["torque", newton_metres]:
            shaft.load(float(newton_metres))
        case ["master", counts, "in", time, "s" | "samples" as unit]:
            motor.master.move(int(counts), float(time) * (talking.SAMPLE_S if unit == "samples" else 1))
        case ["power", "off" | "on" as level]:
            motor.power(level == "on")
        case ["power", "cycle"]:
            motor.power_cycle()
        case ["dip", left, *duration]:
            bench.faults.add(
                "supply_dip", "smartmotor", left=float(left), duration=float(duration[0]) if duration else None
            )
        case ["mend"]:
            bench.faults.mend("supply_dip")
        case ["pins", word]:
            for bit, name in enumerate("ABCDEFG"):
                motor.pins[name].drive(bool(int(word) >> bit & 1))
        case ["clear"]:
            talking.clear(bench, motor)
        case ["air", celsius]:
            motor.ambient = float(celsius)
        case ["writes", *_]:
            motor.serial.write(_characters(act[7:]).encode("latin-1"))
        case ["485", "writes", *_]:
            motor.rs485.write(_characters(act[11:]).encode("latin-1"))
        case ["host", name, value]:
            setattr(host, name, int(value) if value.isdecimal() else value)
        case ["flip", mask]:
            motor.serial.to_device.flip(int(mask, 16))
        case ["break", seconds, "s"]:
            motor.serial.send_break(float(seconds))
        case ["load" | "run" as what, *_]:
            text = act[5:].lstrip() if what == "load" else act[4:]
            program = _characters(text.replace(" / ", "\n")).strip("\n") + "\n"
            (talking.load if what == "load" else talking.run)(bench, motor, program)
        case _:
            return False
    return True


def _holds(bench: Bench, motor: Controller, act: str) -> bool:
    """Make a check; return False if it is none."""
    shaft = motor.axes["shaft"]
    match act.split():
        case ["at", counts]:
            found, expected = shaft.position, int(counts)
        case ["still" | "moving" as state]:
            found, expected = shaft.velocity == 0, state == "still"
        case ["line", number]:
            running = motor.programs["program"].running
            found, expected = (motor.registers["line"].read(), running), (int(number), int(number) - 1)
        case ["lists", *_]:
            found, expected = motor.programs["program"].lines, tuple(act[6:].split(" / "))
        case ["title", *words]:
            found, expected = motor.programs["program"].title, " ".join(words)
        case ["no", "line"]:
            found, expected = motor.programs["program"].running, None
        case ["commanded", counts]:
            found, expected = shaft.commanded, int(counts)
        case ["positions", *counts]:
            found, expected = talking.positions(bench, motor, len(counts)), [int(count) for count in counts]
        case ["steps", *counts]:
            found, expected = talking.steps(bench, motor, len(counts)), [int(count) for count in counts]
        case [number, "steps", "of", counts]:
            found, expected = talking.steps(bench, motor, int(number)), [int(counts)] * int(number)
        case ["turn", *_]:
            where, _, there = act[5:].partition(": ")
            where, _, speed = where.partition(" by ")
            found = scenarios.turn_through(bench, motor, [int(at) for at in where.split()], int(speed or 50))
            expected = [int(at) for at in there.split()] or found
        case [pin, "is", "low" | "high" as level]:
            found, expected = motor.pins[pin].level, level == "high"
        case [pin, "is", volts, "V"]:
            found, expected = motor.pins[pin].volts, float(volts)
        case [pin, "is", "output" | "input" as direction]:
            found, expected = motor.pins[pin].is_output, direction == "output"
        case [expression, ">" | "<" | "!=" as sign, number]:
            now = shaft.position if expression == "at" else talking.value(bench, motor, expression)
            found = {">": now > int(number), "<": now < int(number), "!=": now != int(number)}[sign]
            expected = True
        case [expression, "is", number]:
            found, expected = talking.value(bench, motor, expression), int(number)
        case ["W", *letters]:
            given = "".join(letters)
            found = talking.status_word(bench, motor, 0)
            expected = int(given) if given.isdecimal() else sum(BITS[letter] for letter in given)
        case ["Bits", *letters]:
            found, expected = scenarios.all_bits(bench, motor), "".join(letters)
        case ["receives", *_] | ["485", "receives", *_]:
            port, _, text = act.rpartition("receives ")
            found = (motor.rs485 if port else motor.serial).read()
            expected = b"" if text == "nothing" else found if text == "*" else _characters(text).encode("latin-1")
        case _:
            return False
    assert found == expected, f"{act}: {found}"
    return True
