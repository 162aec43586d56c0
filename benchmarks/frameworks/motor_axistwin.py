"""lewis' example motor: 0 to 250 mm at 2 mm/s; here with 1000 steps a mm, and ramps."""

from axistwin.devices import Device, Lines, Positioner, Refused, Why, command, query

STEPS = 1000


class Motor(Device):
    model, framing = "motor", Lines(b"\r\n")
    axes = {"1": Positioner(velocity=2 * STEPS, acceleration=10 * STEPS)}

    @query("S?")
    def status(self) -> str:
        return "moving" if self.axes["1"].moving else "idle"

    @query("P?")
    def position(self) -> float:
        return self.axes["1"].position / STEPS

    @query("T?")
    def target(self) -> float:
        return self.axes["1"].target / STEPS

    @command("T={target:float 0..250 mm}")
    def move(self, target: float) -> str:
        if self.axes["1"].moving:
            return "err: not idle"
        self.axes["1"].move_to(round(target * STEPS))
        return f"T={target}"

    @command("H")
    def stop(self) -> str:
        self.axes["1"].abort()
        self.axes["1"].target = self.axes["1"].position
        return f"T={self.target()},P={self.position()}"

    def refused(self, reason: Refused, data: bytes) -> str | None:
        return "err: not 0<=T<=250" if reason.why is Why.RANGE else None
