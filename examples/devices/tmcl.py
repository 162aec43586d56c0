"""A three-axis stepper module that speaks TMCL, as Trinamic's TMCM-3351 does; facts from its firmware manual.

Request: address, command, type, motor or bank, value (high byte first), check sum.  A changed setting holds from the
next motion on.  Not here: programs, encoders, COORD with several motors, disabled stop switches, search modes 2 to 6.
"""

from typing import Any

from axistwin.devices import Datagrams, Device, Input, Option, Output, Positioner, Refused, Why, add8, command, query
from axistwin.drivers import TextDriver

STATUS, TYPED = {Why.FORMAT: 1, Why.UNKNOWN: 2, Why.RANGE: 4}, (4, 9, 10, 13, 14, 15, 136)  # TYPED: else status 3.
FASTEST, MOTOR, NUMBER, PLACE = 7_999_774, "{motor:int 0..2}", "{number:int 0..255}", "{number:int 0..20}"
VELOCITY, PORT, VARIABLE = f"{{value:int {-FASTEST}..{FASTEST} pps}}", "{number:int 0..7}", "{number:int 0..55}"
PPS, RAMPS, BYTE = range(FASTEST + 1), range(7_629_279), range(256)
SETTINGS = {  # Axis parameters that can be stored: their values, and their factory settings.
    4: (PPS, 51_200), 5: (RAMPS[1:], 51_200), **dict.fromkeys((6, 7, 200), (BYTE, 0)), 12: ((0,), 0), 13: ((0,), 0),
    15: (PPS, 0), 17: (RAMPS, 0), 140: (range(9), 8), 193: ((1, 7, 8), 1), 194: (PPS, 25_600), 195: (PPS, 2_560),
}  # fmt: skip
READ = {
    0: lambda it: it.target, 1: lambda it: it.position, 3: lambda it: round(it.speed), 9: lambda it: it.at_home,
    8: lambda it: it.position == it.target, 10: lambda it: it.at_limit(+1), 11: lambda it: it.at_limit(-1),
}  # fmt: skip


def request(code: int, number: int, axis: str, value: int = 0) -> bytes:
    return (data := bytes([1, code, number, int(axis)]) + value.to_bytes(4, "big", signed=True)) + add8(data)


class Tmcl(Device):
    model, title = "tmcl", "Three-axis TMCL module"
    framing = Datagrams(
        ">BBBBi address code number motor value", ">BBBBi host address status code value", add8, address="{address:c}"
    )
    options = {"address": Option(1, 1, 255, doc="serial address"), "host": Option(2, 0, 255, doc="that of the host")}
    axes = {f"{n}": Positioner(minus=f"left{n}", plus=f"right{n}", home=f"home{n}") for n in range(3)}
    pins = {f"{side}{n}": Input(level=side != "home") for n in range(3) for side in ("left", "right", "home")}
    pins |= {f"in{n}": Input() for n in range(8)} | {f"out{n}": Output() for n in range(8)}
    driver = TextDriver(
        lambda axis, position: request(4, 0, axis, position), lambda axis: request(6, 1, axis),
        lambda axis: request(6, 3, axis), lambda axis: request(3, 0, axis), at_rest=0, size=9, confirmed=True,
        value=lambda answer: int.from_bytes(answer[4:8], "big", signed=True),
    )  # fmt: skip
    memory = {f"{n}.{motor}": factory for n, (_, factory) in SETTINGS.items() for motor in range(3)}

    def start(self) -> None:
        self.settings, self.places = dict(self.memory), {}
        self.variables, self.speeds, self.searches = [0] * 56, [0] * 3, {}

    def answer(self, result: Any, request: Any) -> Any:
        return result if isinstance(result, bytes) else self.fields(100, request.data, result)

    def refused(self, reason: Refused, data: bytes) -> Any:
        typed = reason.words.startswith("number") or (reason.why is Why.UNKNOWN and data[1] in TYPED)
        return self.fields(3 if typed else STATUS.get(reason.why, 6), data)

    def fields(self, status: int, data: bytes, value: int | None = None) -> dict[str, int]:
        value = int.from_bytes(data[4:8], "big", signed=True) if value is None else int(value)
        return {"host": self.options["host"], "address": data[0], "status": status, "code": data[1], "value": value}

    def ready(self, motor: int, speed: int = 0) -> Positioner:
        axis, self.speeds[motor] = self.axes[str(motor)], speed
        if motor in self.searches:
            self.end(self.searches.pop(motor))
        axis.velocity, axis.acceleration = self.settings[f"4.{motor}"], self.settings[f"5.{motor}"]
        axis.start_velocity, axis.deceleration = self.settings[f"15.{motor}"], self.settings[f"17.{motor}"]
        return axis

    @command(f"code=5 number=2 {MOTOR} {VELOCITY}", section="SAP 2")
    @command(f"code=2 {MOTOR} {VELOCITY}", section="ROL")
    @command(f"code=1 {MOTOR} {VELOCITY}", section="ROR")
    def rotate(self, code: int, motor: int, value: int) -> None:
        self.ready(motor, speed := -value if code == 2 else value).run(speed)

    @command(f"code=13 number=1 {MOTOR}", section="RFS STOP")
    @command(f"code=3 {MOTOR}", section="MST")
    def stop(self, motor: int) -> None:
        self.ready(motor).stop()

    @command(f"code=5 number=1 {MOTOR}", section="SAP 1")
    @command(f"code=5 number=0 {MOTOR}", section="SAP 0")
    @command(f"code=4 number=2 {MOTOR} {{value:int 0..20}}", section="MVP COORD")
    @command(f"code=4 number=1 {MOTOR}", section="MVP REL")
    @command(f"code=4 number=0 {MOTOR}", section="MVP ABS")
    def move(self, code: int, number: int, motor: int, value: int) -> None:
        axis, target = self.ready(motor), self.places.get((motor, value), 0) if number == 2 else value
        act = {(5, 1): axis.define, (4, 1): axis.move_by}.get((code, number), axis.move_to)
        act(target)

    @query(f"code=31 {PLACE} {MOTOR}", section="GCO")
    @command(f"code=30 {PLACE} {MOTOR}", section="SCO")
    def coordinate(self, code: int, number: int, motor: int, value: int) -> int:
        if code == 30:
            self.places[motor, number] = value
        return self.places.get((motor, number), 0)

    @query(f"code=13 number=2 {MOTOR}", section="RFS STATUS")
    @command(f"code=13 number=0 {MOTOR}", section="RFS START")
    def reference_search(self, number: int, motor: int) -> int:
        if number == 0:
            self.searches[motor] = self.begin(self.search(motor, self.ready(motor)))
        return motor in self.searches and self.searches[motor].is_alive

    def search(self, motor: int, axis: Positioner) -> Any:
        mode, fast, slow = (self.settings[f"{n}.{motor}"] for n in (193, 194, 195))
        if mode > 1:
            return (yield from axis.find_home(fast if mode == 8 else -fast, slow))
        axis.run(-fast)
        yield axis.done
        axis.run(slow)
        yield self.pins[f"left{motor}"].changed()
        axis.abort()
        axis.define(0)

    def key(self, number: int, motor: int) -> str:
        if number not in SETTINGS:
            raise Refused(f"number {number}: expected one of {', '.join(map(str, SETTINGS))}")
        return f"{number}.{motor}"

    @command(f"code=5 {{number:int 3..255}} {MOTOR}", section="SAP")
    def set_axis_parameter(self, number: int, motor: int, value: int) -> None:
        key = self.key(number, motor)
        if value not in SETTINGS[number][0]:
            raise Refused(f"value {value}: expected one of {SETTINGS[number][0]}", why=Why.RANGE)
        self.settings[key] = value

    @query(f"code=6 {NUMBER} {MOTOR}", section="GAP")
    def get_axis_parameter(self, number: int, motor: int) -> int:
        if number in READ:
            return READ[number](self.axes[str(motor)])
        return self.speeds[motor] if number == 2 else self.settings[self.key(number, motor)]

    @command(f"code=8 {NUMBER} {MOTOR}", section="RSAP")
    @command(f"code=7 {NUMBER} {MOTOR}", section="STAP")
    def keep(self, code: int, number: int, motor: int) -> None:
        key = self.key(number, motor)
        come, go = (self.settings, self.memory) if code == 7 else (self.memory, self.settings)
        go[key] = come[key]
        self.save()

    @query(f"code=10 {VARIABLE} motor=2", section="GGP")
    @command(f"code=9 {VARIABLE} motor=2", section="SGP")
    def user_variable(self, code: int, number: int, value: int) -> int:
        if code == 9:
            self.variables[number] = value
        return self.variables[number]

    @command(f"code=14 {PORT} motor=2 {{value:int 0..1}}", section="SIO")
    def set_output(self, number: int, value: int) -> None:
        self.pins[f"out{number}"].set(bool(value))

    @query(f"code=15 {PORT} motor=2", section="GIO")
    @query(f"code=15 {PORT} motor=0", section="GIO")
    def get_port(self, number: int, motor: int) -> int:
        return self.pins[f"{'out' if motor else 'in'}{number}"].level

    @query("code=136 number=1", section="136")
    @query("code=136 number=0", section="136")
    def firmware_version(self, number: int) -> int | bytes:
        return 0x0D170100 if number else bytes([self.options["host"]]) + b"3351V100"
