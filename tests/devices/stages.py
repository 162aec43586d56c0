"""Devices of somebody else, as a reader of the documentation writes them."""

from struct import pack, unpack

from axistwin.devices import Datagrams, Device, Input, Lines, Option, Output, Positioner, add8, command, query, register
from axistwin.drivers import TextDriver


class Stage(Device):
    """A two-axis stage that speaks lines of ASCII."""

    model, title, framing = "stage", "Example stage controller", Lines(b"\r")
    axes = {"1": Positioner(velocity=2000, acceleration=20_000, minus="1-", plus="1+"), "2": Positioner(velocity=2000)}
    pins = {"1-": Input(level=True), "1+": Input(level=True), "start": Input(), "lamp": Output()}
    options = {"delay": Option(0.2, 0, 5, doc="seconds of WAIT")}
    memory = {"name": "stage"}
    driver = TextDriver(move="{axis}PA{position}", stop="{axis}ST", position="{axis}TP", busy="{axis}MD")

    @command("{axis}PA{position:int -100000..100000 steps}", section="Absolute move")
    def move_absolute(self, axis: str, position: int) -> None:
        self.axes[axis].move_to(position)

    @command("{axis}ST", section="Stop")
    def stop(self, axis: str) -> None:
        self.axes[axis].stop()

    @query("{axis}TP", section="Tell position")
    def tell_position(self, axis: str) -> int:
        return self.axes[axis].position

    @query("{axis}MD", section="Motion done")
    def motion_done(self, axis: str) -> int:
        return int(not self.axes[axis].moving)

    @command("WAIT", section="Wait", blocks=True)
    def wait(self):
        self.pins["lamp"].set(True)
        yield self.after(self.options["delay"])
        self.pins["lamp"].set(False)
        return "OK"

    @register({0: "axis 1 moves", 1: "axis 2 moves"}, section="Status")
    def status(self) -> int:
        return self.axes["1"].moving | self.axes["2"].moving << 1


def said(code: int, type_: int, axis: str, value: int = 0) -> bytes:
    data = pack(">BBBBi", 1, code, type_, int(axis), value)
    return data + add8(data)


class Module(Device):
    """A three-axis module that speaks datagrams of nine bytes."""

    model, title = "module", "Example motion module"
    framing = Datagrams(">BBBBi address code type motor value", ">BBBBi host address status code value", check=add8)
    axes = {name: Positioner(velocity=2000, acceleration=20_000) for name in "012"}

    driver = TextDriver(
        move=lambda axis, position: said(4, 0, axis, position), stop=lambda axis: said(3, 0, axis),
        position=lambda axis: said(6, 1, axis), busy=lambda axis: said(6, 8, axis),
        confirmed=True, size=9, value=lambda answer: unpack(">i", answer[4:8])[0],
    )  # fmt: skip

    @command("code=4 type=0 {motor:int 0..2} {value:int}", section="MVP ABS")
    def move_absolute(self, motor: int, value: int) -> int:
        self.axes[str(motor)].move_to(value)
        return value

    @command("code=3 {motor:int 0..2}", section="MST")
    def stop(self, motor: int) -> int:
        self.axes[str(motor)].stop()
        return 0

    @query("code=6 type=1 {motor:int 0..2}", section="GAP 1")
    def position(self, motor: int) -> int:
        return self.axes[str(motor)].position

    @query("code=6 type=8 {motor:int 0..2}", section="GAP 8")
    def reached(self, motor: int) -> int:
        return int(not self.axes[str(motor)].moving)

    def answer(self, result, request):
        return {"host": 2, "address": 1, "status": 100, "code": request.values["code"], "value": result or 0}
