"""Three steppers X, Y and Z on a party line, each with a controller and a program, that speak as MDrive does: `XPR P`.

The option `program` is stored in each motor: `XEX F1` executes it from the label F1 on, and SU is executed at power-on.
Not here: input of programs, HM outside of them, trips, check sums, encoders.  Source: the manual of MCode.
"""

import operator
import re
from typing import Any

from axistwin.devices import Device, Input, Lines, Option, Positioner, Refused, Request, Why, command, query

PROGRAM = "LB SU; VA CT = 0; VA C0 = 51200; E; LB F1; SL 0; H; E; LB F2; HM 1; MR C0; H; P = 0; E"
FACTORY = {
    "A": 1_000_000, "D": 1_000_000, "VI": 1000, "VM": 768_000, "RC": 25, "HC": 5, "HT": 500, "MT": 0, "MS": 256,
    "LM": 1, "EM": 0, "ER": 0, "R1": 0, "R2": 0, "R3": 0, "R4": 0,
}  # fmt: skip
RANGES = dict.fromkeys("AD", range(91, 10**9)) | dict.fromkeys(("VI", "VM"), range(1, 5_000_001)) | {"EM": range(4)}
FIXED = {"S1": "1, 1, 0", "S2": "2, 1, 0", "S3": "3, 1, 0", "S4": "0, 1, 0", "PN": "MDI", "SN": "1", "VR": "1", "PY": 1}
READ_ONLY = ("P", "V", "MV", "VC", "EF", "UV", *FIXED)
SIGNS = {"+": operator.add, "-": operator.sub, "&": operator.and_, "=": operator.eq, "<": operator.lt, ">": operator.gt}
VALUE = re.compile(r"\s*(-?\w{1,12})\s*(?:([-+&=<>])\s*(-?\w{1,12}))?\s*", re.ASCII)
LINE = re.compile(r"\s*(\w*)\s*(=?)\s*(.*?)\s*", re.ASCII)


class MDrive(Device):
    model, title = "mdrive", "Three MDrive-like motors on a party line"
    framing = Lines(b"\n", ignore=b"\r", ignore_case=True, at_once=b"\x1b")
    options = {"program": Option(PROGRAM, doc="the stored program, lines with semicolons between them")}
    axes = {n: Positioner(minus=f"{n}minus", plus=f"{n}plus", home=f"{n}home") for n in "XYZ"}
    pins = {f"{n}{side}": Input(level=side != "home") for n in "XYZ" for side in ("minus", "plus", "home")}
    memory = {n: dict(FACTORY) for n in "XYZ"}

    def start(self) -> None:
        self.lines = [m.groups() for m in map(LINE.fullmatch, self.options["program"].upper().split(";")) if m]
        self.labels = {rest: number for number, (word, _, rest) in enumerate(self.lines) if word == "LB"}
        self.values = {n: dict(stored) for n, stored in self.memory.items()}
        self.runs = dict.fromkeys(self.axes, 0)  # A program ends when its number is no longer here.
        if "SU" in self.labels:
            self.execute(None, "SU")

    def answer(self, result: Any, request: Request) -> bytes | None:
        return self.echoed(request.values.get("axis") or "", request.data, result)

    def refused(self, reason: Refused, data: bytes) -> bytes | None:
        axis = data[:1].decode("latin-1").upper()
        self.values.get(axis, {})["ER"] = reason.code or {Why.UNKNOWN: 20, Why.RANGE: 21}.get(reason.why, 24)
        return self.echoed(axis, data, None, prompt="?")

    def echoed(self, axis: str, data: bytes, text: str | None, prompt: str = "") -> bytes | None:
        """Return an answer as the echo mode EM wants it; a line for other motors has none."""
        mode = self.values[axis]["EM"] if axis in self.axes else 2
        line = f"{text or prompt}\r\n".encode() if text or (prompt and mode) or mode in (1, 2) else b""
        if mode in (1, 2):
            return None if mode == 2 and text is None else line
        return data + b"\r\n" + line + (b"" if mode else (prompt or ">").encode())

    def limit_reached(self, axis: str, side: int) -> None:
        self.values[axis]["ER"] = 83 if side > 0 else 84

    def value(self, axis: str, name: str) -> Any:
        own, moved = self.values[axis] | FIXED, self.axes[axis]
        if name == "UV":
            user = [f"{key} = G {number}\r\n" for key, number in own.items() if key not in (*FACTORY, *FIXED)]
            return "".join(user + [f"{label} = {100 + line}\r\n" for label, line in self.labels.items()])
        flags = {"MV": moved.moving, "VC": moved.moving and abs(moved.speed) != moved.velocity, "EF": own["ER"] > 0}
        known = own | {"P": moved.position, "V": round(moved.speed)} | {key: int(flag) for key, flag in flags.items()}
        if name not in known:
            raise Refused(f"unknown variable {name}", 30)
        return known[name]

    def result(self, axis: str, text: str) -> int:
        """Return the value of a text such as `A` or `P & 1023`."""
        found = VALUE.fullmatch(text.upper())
        if not found:
            raise Refused(f"{text!r}: expected a number, a variable, or two with a sign between them", 24)
        values = [it if it.lstrip("-").isdecimal() else self.value(axis, it) for it in found.group(1, 3) if it]
        return int(SIGNS[found[2]](*map(int, values)) if found[2] else values[0])

    @command("{axis}VA {name:word}[ ]=[ ]{value:text}", section="VA")
    def declare(self, axis: str, name: str, value: str) -> None:
        if (name := name.upper()) in (*FACTORY, *READ_ONLY, *self.labels) or len(name) > 2:
            raise Refused(f"{name}: expected a new name of one or two characters", 29)
        self.values[axis][name] = self.result(axis, value)

    @command("{axis}{name:EM|PY} {value:text}", section="EM, PY")
    @command("{axis}{name:word}[ ]=[ ]{value:text}", section="variables and flags")
    def assign(self, axis: str, name: str, value: str) -> None:
        own, name, number = self.values[axis], name.upper(), self.result(axis, value)
        if name == "P":
            self.axes[axis].define(number)
        elif name not in own:
            raise Refused(f"{name} cannot be set", 25 if name in READ_ONLY else 20)
        elif number not in RANGES.get(name, (number,)):
            raise Refused(f"{name}={number} is out of range", 21)
        elif (own | {name: number})["VI"] >= (own | {name: number})["VM"]:
            raise Refused("VI must be below VM", 22 if name == "VI" else 23)
        else:
            own[name] = number

    @query("{axis}PR {items:text}", section="PR")
    def show(self, axis: str, items: str) -> str:
        found = re.findall(r'"([^"]*)"|(\w+)', items, re.ASCII)
        return "".join(str(self.value(axis, name.upper())) if name else text for text, name in found)

    @command("{axis}S", section="S", after=0.5)
    def store(self, axis: str) -> None:
        self.memory[axis] = dict(self.values[axis])
        self.save()

    @command("{axis}", section="party mode")
    def attention(self, axis: str) -> None: ...

    @command("{axis}{word:MA|MR|SL} {value:text}", section="MA, MR, SL")
    def move(self, axis: str, word: str, value: str) -> None:
        own, moved, number = self.values[axis], self.axes[axis], self.result(axis, value)
        moved.start_velocity, moved.velocity = own["VI"], abs(number) if word == "SL" and number else own["VM"]
        moved.acceleration, moved.deceleration = own["A"], own["D"]
        {"MA": moved.move_to, "MR": moved.move_by, "SL": moved.run}[word](number)

    @command("\x1b", section="ESC")
    def stop_all(self) -> str:
        for axis in self.axes:
            self.runs[axis] += 1
            self.axes[axis].stop()
        return ""

    @command("[{axis}][*]EX {label:word}", section="EX")
    def execute(self, axis: str | None, label: str) -> None:
        if (label := label.upper()) not in self.labels:
            raise Refused(f"unknown label {label}", 30)
        for name in axis or self.axes:
            self.values[name]["ER"] = 0
            self.runs[name] += 1
            self.begin(self.program(name, self.labels[label]))

    def program(self, axis: str, line: int) -> Any:
        run, calls, own = self.runs[axis], [len(self.lines)], self.values[axis]
        while self.runs[axis] == run and line < len(self.lines):
            yield self.after(0.001)
            (word, equal, rest), line = self.lines[line], line + 1
            label, _, condition = rest.partition(",")
            try:
                if equal:
                    self.assign(axis, word, rest)
                elif word == "VA":
                    self.declare(axis, *map(str.strip, rest.split("=")))
                elif word in ("MA", "MR", "SL"):
                    self.move(axis, word, rest)
                elif word == "HM":
                    self.move(axis, "SL", "0")
                    yield from self.axes[axis].find_home(own["VM"] if rest == "3" else -own["VM"], own["VI"])
                elif word == "H":
                    yield self.after(int(rest) / 1000) if rest else self.axes[axis].done
                elif word in ("BR", "CL") and (not condition or self.result(axis, condition)):
                    calls, line = calls[-9:] + [line] * (word == "CL"), self.labels[label.strip()]
                elif word in ("RT", "E"):
                    line = calls.pop() if word == "RT" else len(self.lines)
            except (Refused, KeyError, TypeError, ValueError) as reason:
                own["ER"] = getattr(reason, "code", 24)
