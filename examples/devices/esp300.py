"""A three-axis servo controller that speaks as Newport's ESP300 does, e.g. `1PA12.5;1WS;1TP?`.

A unit is that of the user: a count is SU units, and SN is a label only.  Errors go into a queue for TE? and TB?.
Not here: groups, programs, jogging, gains, digital ports, spaces within a command.  Source: the ESP300's manual.
"""

import re
from typing import Any

from axistwin.devices import Device, Input, Lines, Positioner, Refused, Why, command, query, register
from axistwin.drivers import TextDriver

CYCLE = 0.0004  # Seconds; the time stamps of errors count cycles of the servo.
GENERAL = {
    0: "NO ERROR DETECTED", 6: "COMMAND DOES NOT EXIST", 7: "PARAMETER OUT OF RANGE", 9: "AXIS NUMBER OUT OF RANGE",
    37: "AXIS NUMBER MISSING", 38: "COMMAND PARAMETER MISSING",
}  # fmt: skip
OF_AXIS = {
    1: "PARAMETER OUT OF RANGE", 3: "FOLLOWING ERROR THRESHOLD EXCEEDED", 4: "POSITIVE HARDWARE LIMIT DETECTED",
    5: "NEGATIVE HARDWARE LIMIT DETECTED", 6: "POSITIVE SOFTWARE LIMIT DETECTED",
    7: "NEGATIVE SOFTWARE LIMIT DETECTED", 10: "MAXIMUM VELOCITY EXCEEDED", 11: "MAXIMUM ACCELERATION EXCEEDED",
    13: "MOTOR NOT ENABLED", 20: "HOMING ABORTED",
}  # fmt: skip
# Resolution, velocity, acceleration, deceleration, their maxima, speeds of the home search, software limits, unit.
FACTORY = {
    "SU": 0.001, "VA": 10, "AC": 40, "AG": 40, "VU": 20, "AU": 100, "OH": 5, "OL": 0.5, "SL": -50, "SR": 50, "SN": 2,
}  # fmt: skip
SET, MOST = "|".join(FACTORY), {"VA": "VU", "OH": "VU", "OL": "VU", "AC": "AU", "AG": "AU"}
KNOWN = re.compile(rf"(\d*)(?:AB|DH|DP|MD|MF|MO|MV|OR|PA|PR|SM|ST|TB|TE|TP|TS|TV|VE|WS|WT|{SET})(.*)", re.ASCII)


class Esp300(Device):
    model, title, line = "esp300", "Three-axis ESP300-like controller", "19200 8N1"
    framing = Lines(b"\r", ending=b"\r\n", ignore=b" \n", ignore_case=True, separator=b";")
    axes = {n: Positioner(10_000, servo=True, minus=f"minus{n}", plus=f"plus{n}", home=f"home{n}") for n in "123"}
    pins = {f"{side}{n}": Input(level=side != "home") for n in "123" for side in ("minus", "plus", "home")}
    memory = {n: dict(FACTORY) for n in "123"}
    driver = TextDriver("{axis}MO;{axis}PA{position}", "{axis}TP", "{axis}MD?", "{axis}ST", counts=1000)

    def start(self) -> None:
        self.settings = {n: dict(stored) for n, stored in self.memory.items()}
        self.errors, self.searches = list[tuple[int, int, str]](), dict[str, Any]()
        self.powered, self.reporting = dict.fromkeys(self.axes, False), dict.fromkeys(self.axes, True)

    def error(self, code: int, axis: str = "0") -> None:
        words = GENERAL[code] if axis == "0" else f"AXIS-{axis} {OF_AXIS[code]}"
        self.errors = [*self.errors[-9:], (100 * int(axis) + code, round(self.now / CYCLE), words)]

    def refused(self, reason: Refused, data: bytes) -> None:
        found = KNOWN.fullmatch(data.decode("latin-1").upper())
        axis = re.match(rb"(\d*)", data)[1].decode()  # type: ignore[index]  # it always matches
        if reason.code:
            self.error(reason.code, axis)
        elif not found or axis not in ("", *self.axes):
            self.error(9 if found else 6)
        else:
            self.error(37 if not axis else 7 if found[2] or reason.why is Why.RANGE else 38)

    def limit_reached(self, axis: str, side: int) -> None:
        if self.reporting[axis]:
            self.error({+1: 4, -1: 5, 0: 3}[side], axis)

    @query("T{form:E|B}[?]", section="TE, TB")
    def read_error(self, form: str) -> str:
        code, cycle, words = self.errors.pop(0) if self.errors else (0, round(self.now / CYCLE), GENERAL[0])
        return str(code) if form == "E" else f"{code}, {cycle}, {words}"

    @command(f"{{axis}}{{name:{SET}}}{{value:float}}", section=SET.replace("|", ", "))
    def set_value(self, axis: str, name: str, value: float) -> None:
        own = self.settings[axis]
        if (value <= 0 and name not in ("SL", "SR", "SN")) or (name == "SN" and value not in range(12)):
            raise Refused(f"{name} {value} is out of range", 1)
        if name in MOST and value > own[MOST[name]]:
            raise Refused(f"{name} {value} exceeds {MOST[name]}", 10 if MOST[name] == "VU" else 11)
        own[name] = value

    @query("{axis}{name:TP|TV|DP}", section="TP, TV, DP")
    @query(f"{{axis}}{{name:TP|TV|DP|PA|MD|MO|{SET}}}?", section="TP, TV, DP, PA, MD, MO and settings")
    def read(self, axis: str, name: str) -> str:
        own, moved = self.settings[axis], self.axes[axis]
        if name in own:
            return f"{own[name]:g}"
        if name in ("MD", "MO"):
            return str(int(self.powered[axis] if name == "MO" else not moved.moving))
        target = moved.target if moved.moving else moved.commanded
        counts = {"TP": moved.position, "TV": moved.speed, "DP": moved.commanded, "PA": target}[name]
        return f"{counts * own['SU'] + 0:.4f}"

    @command("SM", section="SM")
    def store(self) -> None:
        self.memory.update({n: dict(own) for n, own in self.settings.items()})
        self.save()

    @register({0: "axis 1 moves", 1: "axis 2 moves", 2: "axis 3 moves", 4: "motor power"}, section="TS", restless=True)
    def status(self) -> int:
        return sum(self.axes[n].moving << k for k, n in enumerate("123")) | any(self.powered.values()) << 4

    @query("{name:VE|TS}[?]", section="VE, TS")
    def read_controller(self, name: str) -> str:
        return "ESP300-like Version 1.0" if name == "VE" else chr(self.status() | 0x40)

    def ready(self, axis: str) -> Positioner:
        if not self.powered[axis]:
            raise Refused("the motor power is off: send MO", 13)
        if axis in self.searches:
            self.end(self.searches.pop(axis))
        own, moved = self.settings[axis], self.axes[axis]
        moved.velocity, moved.acceleration, moved.deceleration = (own[name] / own["SU"] for name in ("VA", "AC", "AG"))
        self.reporting[axis] = True
        return moved

    @command("{axis}P{way:A|R}{to:float units}", section="PA, PR")
    def move(self, axis: str, way: str, to: float) -> None:
        moved, own = self.ready(axis), self.settings[axis]
        to += (moved.target if moved.moving else moved.commanded) * own["SU"] if way == "R" else 0
        if not own["SL"] <= to <= own["SR"]:
            raise Refused(f"{to} is beyond a software limit", 6 if to > own["SR"] else 7)
        moved.move_to(round(to / own["SU"]))

    @command("{axis}MV{direction:+|-}", section="MV")
    def move_on(self, axis: str, direction: str) -> None:
        (moved := self.ready(axis)).run(moved.velocity if direction == "+" else -moved.velocity)

    @command("{axis}OR[{mode:int 0..4}]", section="OR")
    def search_home(self, axis: str, mode: int | None) -> None:
        self.searches[axis] = self.begin(self.search(axis, mode, self.ready(axis)))

    def search(self, axis: str, mode: int | None, moved: Positioner) -> Any:
        fast, slow = (self.settings[axis][name] / self.settings[axis]["SU"] for name in ("OH", "OL"))
        if mode == 0:
            moved.move_to(0)
        elif mode in (3, 4):
            self.reporting[axis] = False
            moved.run(fast if mode == 3 else -fast)
            yield moved.done
            if moved.stopped_by and not self.reporting[axis]:
                moved.define(0)
        elif not (yield from moved.find_home(fast, slow)):
            self.error(20, axis)

    @command("{axis}DH[{position:float units}]", section="DH")
    def define_home(self, axis: str, position: float | None) -> None:
        self.axes[axis].define(round((position or 0) / self.settings[axis]["SU"]))

    @command("{axis}M{power:O|F}", section="MO, MF")
    def switch_motor(self, axis: str, power: str) -> None:
        self.powered[axis] = power == "O"
        if power == "F":
            self.axes[axis].abort()

    @command("[{axis}]{how:ST|AB}", section="ST, AB")
    def stop(self, axis: str | None, how: str) -> None:
        for name in axis or self.axes:
            self.axes[name].stop() if how == "ST" else self.axes[name].abort()

    @command("[{axis}]W{what:S|T}[{delay:int 0..60000 ms}]", section="WS, WT", blocks=True)
    def wait(self, axis: str | None, what: str, delay: int | None) -> Any:
        for name in (axis or self.axes) if what == "S" else ():
            yield self.axes[name].done
        yield self.after((delay or 0) / 1000)
