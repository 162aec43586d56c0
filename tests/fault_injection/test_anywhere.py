"""Random faults at random times and places: no exception, no endless loop, and reproducible results."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.faults.table import Sort
from axistwin.core.errors import UsageError

PLACES = {
    "LINE": ("if1.serial", "motor.serial"),
    "PIN": ("if1.input1", "if1.output1", "1811.step", "1811.cw_limit", "motor.C", "motor.index", "motor.brake"),
    "AXIS": ("if1.X", "1811.motor", "motor.shaft"),
    "CONTROLLER": ("if1", "1811", "motor"),
}
EVENTS = (None, "if1.X passes 300", "motor.shaft passes 500 up", "if1.output1 rises", "if1 hears N", "if1 says 0",
          "motor raises Be", "1811.motor passes 1000")  # fmt: skip


def value_of(parameter):
    if parameter.sort is Sort.LEVEL:
        return st.booleans()
    if parameter.sort is Sort.WORD:
        return st.sampled_from(parameter.words)
    low, high = parameter.low or 0, min(1000 if parameter.high is None else parameter.high, 1000)
    low = max(low, -1000)
    return st.integers(int(low), int(high)) if parameter.sort is Sort.WHOLE else st.floats(max(low, 0.001), high)


@st.composite
def fault(draw):
    kind = KINDS[draw(st.sampled_from(sorted(KINDS)))]
    return {
        "kind": kind.name,
        "on": draw(st.sampled_from(PLACES[kind.on.name])),
        "at": draw(st.floats(0, 4)),
        "when": draw(st.sampled_from(EVENTS)),
        "duration": None if kind.at_once else draw(st.none() | st.floats(0, 2)),
        "seed": draw(st.integers(0, 99)),
        **{parameter.name: draw(value_of(parameter)) for parameter in kind.parameters},
    }


def run(faults):
    bench = Bench()
    if1 = bench.add("if1", X={"encoder": {}, "motor": {"torque": [[0, 1.0], [5000, 0.5]]}})
    board = bench.add("1811", motor={"encoder": {}, "limits": (-10_000, 10_000)})
    motor = bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    for given_fault in faults:
        try:
            bench.faults.add(**given_fault)
        except UsageError:
            continue  # the fault is impossible at this place
    motor.serial.write(b"UCI UDI ZS MP A=100 V=100000 P=2000 G ")
    with_board = board.product.attend(board.bus)
    for command in ("310000000061A80003D090", "33000061A8"):
        with_board.write(bytes.fromhex(command))
    for words in (b"(", b"(", b"U61\r", b"X1000S1$\r", b"N\r", b"X-$\r"):
        bench.run(0.8)
        if1.serial.write(words)
    bench.run(2)
    axes = [axis for controller in bench.controllers.values() for axis in controller.axes.values()]
    return if1.serial.read(), motor.serial.read(), [(axis.position, axis.encoder.count) for axis in axes
                                                    if axis.name in ("X", "motor", "shaft")]  # fmt: skip


@settings(max_examples=20, deadline=None)
@given(st.lists(fault(), min_size=1, max_size=3))
def test_any_faults_at_any_time(faults):
    assert run(faults) == run(faults)
