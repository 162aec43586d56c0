"""Characters that are requests without a terminator, such as Escape for an emergency stop."""

from axistwin.devices import Device, Lines, Positioner, command, query

from .made import ask, on_a_bench


class Stoppable(Device):
    model, framing = "stoppable", Lines(at_once=b"\x1b", address="7")
    axes = {"1": Positioner(velocity=1000, acceleration=10_000)}

    @command("{axis}MV")
    def move(self, axis):
        self.axes[axis].run(1000)

    @command("\x1b")
    def stop(self):
        self.axes["1"].abort()

    @query("{axis}TP")
    def position(self, axis):
        return self.axes[axis].position


def test_it_acts_without_a_terminator_and_for_all_addresses():
    bench, controller = on_a_bench(Stoppable)
    ask(bench, controller, b"71MV\r", 1.0)
    ask(bench, controller, b"\x1b")
    assert ask(bench, controller, b"71TP\r") == b"950\r"  # 50 in 0.1 s, 900 in 0.9 s


def test_it_drops_the_line_that_has_begun():
    bench, controller = on_a_bench(Stoppable)
    ask(bench, controller, b"71M\x1bV\r71M\x1b71MV\r", 0.6)
    assert ask(bench, controller, b"71TP\r") == b"550\r"
