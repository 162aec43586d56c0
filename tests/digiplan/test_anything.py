"""Random actions of host, wires, switches and power: no exception, no endless wait, the same result each time."""

from collections.abc import Callable, Sequence

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim.frames import LineError

from .talking import (
    arrivals,
    ask,
    command,
    each_character,
    edges,
    initialise,
    moves,
    moving,
    play,
    positions,
    ready,
    send,
    write,
)

LANGUAGE = "XYZ+-0123456789$@<>^BGHLSRP,/:=A%#DKIOQEFN[]()*UV \r\n"

COMMANDS = [
    "X10$", "Y-20@300$", "XYZ+5$", "XG$", "Y-G$", "#", "@1000", ">2", "<3", "^20", "B-5", "XB$", "D1", "D0",
    "S1$", "R1$", "S12R3$", "P1,5$", "P0,9$", "H1X5$", "L2X5$", "X400S1$", "K", "I", "O", "Q", "E", "F", "N", "[", "]",
    ":X10:Y:=2,1:$", ":$", ":H1:X5:$", ":XG:H1A:$", ":X5:%:Y:$", "%", "X100/Y50@500$", "XY/Z$", ":", "$", "(", "*",
    "U61", ":S1:X40@600:P2,5:Y-40:=2,2:R1:$", ":X@500G:P0,9:A:%:Y9:$", "X100/Y30$", "H1L2X9$", "P4,20$", "X-@700G$",
]  # fmt: skip

messages = st.one_of(
    st.sampled_from(COMMANDS).map(str.encode), st.text(LANGUAGE, max_size=12).map(str.encode), st.binary(max_size=8)
)


class Act:
    """A random action on the bench, with a name that Hypothesis prints."""

    def __init__(self, text: str, does: Callable[[Bench, Controller], object]) -> None:
        self.text, self.does = text, does

    def __repr__(self) -> str:
        return self.text


def drive(pin: str, level: bool) -> Act:
    return Act(f"{pin}={level}", lambda bench, it: it.pins[pin].drive(level))


def host(line: str, value: object) -> Act:
    return Act(f"host.{line}={value}", lambda bench, it: setattr(it.serial.host, line, value))


PINS = ("input1", "input2", "input3", "estop", "limit_plus", "limit_minus", "x_fault", "y_fault")
LEVELS = [drive(pin, level) for pin in PINS for level in (True, False)]
TROUBLE = [
    *LEVELS,
    *(drive("supply", level) for level in (True, False)),
    *(host(line, value) for line in ("dtr", "rts") for value in (True, False)),
    *(host("baudrate", value) for value in (110, 1200, 4800, 9600, 115_200)),
    *(host("parity", value) for value in "NEOMS"),
    *(host("bytesize", value) for value in (5, 7, 8)),
    Act("break", lambda bench, it: it.serial.send_break(0.02)),
    Act("lose", lambda bench, it: it.serial.to_device.lose(2)),
    Act("double", lambda bench, it: it.serial.to_device.double(2)),
    Act("flip", lambda bench, it: it.serial.to_device.flip(0x81, 3)),
    Act("cut", lambda bench, it: (it.serial.to_device.cut(), it.serial.from_device.cut())),
    Act("mend", lambda bench, it: (it.serial.to_device.mend(), it.serial.from_device.mend())),
    Act("off", lambda bench, it: it.power(False)),
    Act("on", lambda bench, it: it.power(True)),
    Act("cycle", lambda bench, it: it.power_cycle()),
    Act("begin", lambda bench, it: it.serial.write(b"(U61\r")),
    Act("X jams", lambda bench, it: it.axes["X"].jam()),
    Act("X is free", lambda bench, it: it.axes["X"].jam(False)),
]

sayings = st.one_of(messages, messages.map(lambda data: data + b"\r")).map(
    lambda data: Act(repr(data), lambda bench, it: it.serial.write(data))
)
times = st.floats(0, 0.3) | st.sampled_from([0.0, 0.001, 0.02, 1.1, 5.0])
waits = times.map(lambda seconds: Act(f"+{seconds}", lambda bench, it: bench.run(seconds)))
acts = sayings | st.sampled_from(TROUBLE) | waits

given_anything = given(
    st.sampled_from(["if1", "if2"]),
    st.sampled_from(["U61", "U62", "V61", "V15", "U37", "U81"]),
    st.sampled_from(["9600 8N2", "instant"]),
    st.sampled_from(["5-wire", "3-wire", "3-wire DSR-DTR", "IBM PC 5-wire"]),
    st.lists(acts, max_size=25),
)


def live(model: str, form: str, line: str, wiring: str, happenings: Sequence[Act]) -> tuple[object, ...]:
    """Return everything observable of a bench after these actions."""
    bench = Bench()
    it = ready(bench, form, model, line=line, wiring=wiring)
    received: list[tuple[int, int, LineError]] = arrivals(bench, it)
    changes: list[tuple[int, str, bool]] = []
    for name, pin in it.pins.items():
        pin.subscribe(lambda pin, name=name: changes.append((bench.now, name, pin.level)))
    for happening in happenings:
        happening.does(bench, it)
    bench.run(3)
    motion = [(move.start_ns, move.direction, move.origin) for axis in it.axes.values() for move in axis.train.moves]
    first = [axis.pulse_times(0, 5_000_000_000).tolist()[:50] for axis in it.axes.values()]
    return received, changes, motion, first, [axis.position for axis in it.axes.values()], bench.now


@settings(max_examples=150)
@given_anything
def test_anything_at_any_time_neither_raises_nor_hangs(model, form, line, wiring, happenings):
    """After any actions, once all faults are removed and the power is cycled, the interface works as when new."""
    bench = Bench()
    it = ready(bench, form, model, line=line, wiring=wiring)
    for happening in happenings:
        happening.does(bench, it)
    bench.run(2)
    put_right(bench, it)
    if (model, wiring) == ("if2", "3-wire"):
        return  # DSR is low at power-up: a locked IF2 then answers only its own baud rate and format
    bench.run(1.5)
    write(it, "(*", end="")  # this breaks into a locked IF2; an IF1 ignores it
    bench.run(0.5)
    send(bench, it, "\rU61", seconds=1.5)
    before = it.axes["X"].position
    send(bench, it, "X7$", seconds=1)
    assert it.axes["X"].position == before + 7 and ask(bench, it, "E") == b"C\r"


def put_right(bench: Bench, it: Controller) -> None:
    """Restore every wire, switch and shaft, and cycle the power."""
    for pin in it.pins.values():
        pin.release()
    it.axes["X"].jam(False)
    it.serial.to_device.mend()
    it.serial.from_device.mend()
    it.serial.drop_pending()
    bench.run(3)  # the end of a break or of a character at 110 baud
    it.power(False)
    host = it.serial.host
    host.baudrate, host.bytesize, host.parity, host.stopbits, host.dtr, host.rts = 9600, 8, "N", 2, True, True
    it.serial.write(bytes(9))  # they use up the remaining faults of the line
    bench.run(0.5)
    it.power(True)


@settings(max_examples=40)
@given_anything
def test_two_runs_are_identical(model, form, line, wiring, happenings):
    """The same inputs at the same virtual times give the same bytes and the same pulses."""
    assert live(model, form, line, wiring, happenings) == live(model, form, line, wiring, happenings)


@settings(max_examples=60)
@given(
    st.lists(sayings | st.sampled_from(LEVELS) | waits, max_size=14),
    st.sampled_from(("if1", "if2")),
    st.sampled_from(("U61", "U62", "V61")),
)
def test_after_any_bytes_and_levels_it_works_without_a_power_cycle(happenings, model, form):
    """Wrong input is ignored and sets a flag; afterwards the interface still works."""
    bench = Bench()
    it = ready(bench, form, model)
    for happening in happenings:
        happening.does(bench, it)
    for name in PINS:
        it.pins[name].release()
    bench.run(2)
    end = "\n" if form[0] == "V" else "\r"
    for text in ("", form, "]", "#", "K", "K", "F", "D0"):  # the format is needed if a `(` after `[` has broken in
        send(bench, it, text, seconds=1.2, end=end)
    bench.run(20)
    it.serial.read()
    assert b"C" in ask(bench, it, "E", end=end)
    before = positions(it)
    send(bench, it, "@400", "X7$", seconds=1, end=end)
    assert positions(it) == (before[0] + 7, *before[1:])


TIMELESS = [
    "X10$", "Y-20@300$", "XYZ+5$", "@350", "@9000", "@99999", "B-5", "XB$", "X-B$", "S1$", "R1$", "S12R3$", "P1,5$",
    "X40S1$", ":X10:Y:=2,1:$", ":$", "X200/Y50@500$", "?", "X", "  ", "", "B5", "Z100@3000$", "^20", "<5",
]  # fmt: skip
"""Messages whose replies and moves do not depend on their times; status requests are answered at any time."""


def outcome(bench: Bench, it: Controller) -> tuple[object, ...]:
    bench.run(60)
    assert not moving(it)
    moved = [moves(axis) for axis in it.axes.values()]
    return it.serial.read(), moved, [pin.level for pin in it.pins.values()], ask(bench, it, "F")


def obeying_dtr(form: str) -> tuple[Bench, Controller]:
    """Return an interface whose host sends nothing while DTR is off, so that the buffer never overflows."""
    bench = Bench()
    it = ready(bench, form, line="2400 8N2")
    it.serial.dtr_line.subscribe(lambda pin: setattr(it.serial, "held", not pin.level))
    return bench, it


@settings(max_examples=40)
@given(st.lists(st.sampled_from(TIMELESS), max_size=6), st.floats(0, 0.05), st.sampled_from(["U61", "U62", "U24"]))
@example(["^20", "X10$", *[":X10:Y:=2,1:$"] * 4], 0.0, "U61")  # 61 characters while the ramp is calculated
def test_fed_whole_or_byte_by_byte_the_same(said, pause, form):
    """A message has the same effect at once as byte by byte with pauses."""
    text = "".join(message + "\r" for message in said)
    whole, first = obeying_dtr(form)
    write(first, text, end="")
    bit_by_bit, second = obeying_dtr(form)
    each_character(bit_by_bit, second, text, lambda n: bit_by_bit.run(pause))
    bit_by_bit.run(60)
    assert outcome(whole, first) == outcome(bit_by_bit, second)


@pytest.mark.parametrize("step", [0.0001, 0.0137, 2.0])
def test_it_does_not_matter_in_what_steps_time_is_advanced(step):
    """Each event has its exact time, whatever the length of the steps in which time is advanced."""

    def session(step: float) -> tuple[object, ...]:
        bench = Bench()
        it = ready(bench, "U62", recalculation_s=0.05)
        received, output = arrivals(bench, it), edges(it.pins["output1"])
        write(it, "B-20^30", "X100@900BS1$", "P1,3$", "K")
        for _ in range(round(2 / step)):
            bench.run(step)
        bench.run_until(lambda: False, 2.5 - round(2 / step) * step)
        return received, output, it.axes["X"].pulse_times().tolist(), bench.now

    assert session(step) == session(0.5)


@settings(max_examples=60)
@given(st.binary(max_size=60))
def test_rubbish_before_initialisation_does_no_harm(rubbish):
    """Initialisation: only `(` is accepted; if the random bytes contain one, a later `(` is answered too.

    Random bytes can read as `(` at a lower baud rate (80h is low for 8 bits, which are 4 bits at half the rate): then
    the answer comes at that rate only.
    """
    bench = Bench()
    if1 = bench.add("if1")
    bench.run(0.97)
    if1.serial.write(rubbish.replace(b"U", b"").replace(b"V", b"").replace(b"\xd5", b"").replace(b"\xd6", b""))
    bench.run(1)
    assume(if1.serial.read().replace(b"U\r", b"") == b"")
    if1.serial.write(b"\r")
    bench.run(0.01)
    assert ask(bench, if1, "(", end="") == b"U\r"


@given(
    line=st.builds(
        "{} {}{}{}".format,
        st.sampled_from((300, 1200, 2400, 4800, 9600)),
        st.sampled_from((7, 8)),
        st.sampled_from("NEO"),
        st.sampled_from((1, 2)),
    ),
    data=st.lists(st.sampled_from((b"(", b"U", b"61", b"\r", b"+", b"G", b"\0", b"\xff", b"((")), max_size=6).map(
        b"".join
    ),
)
@example(line="9600 7N1", data=b"(+")
@example(line="9600 7O1", data=b"G\r%\r")
@settings(max_examples=60)
def test_characters_of_any_frame_before_initialisation(line, data):
    """Initialisation: after any characters in another format, a host in the right format gets its `U`."""
    bench = Bench()
    if1 = bench.add("if1", line=line)
    bench.run(1.5)
    if1.serial.write(data)
    bench.run(1.0)
    if1.power_cycle()
    host = if1.serial.host
    host.bytesize, host.parity, host.stopbits = 8, "N", 2
    bench.run(1.5)
    if1.serial.read()
    if1.serial.write(b"(")
    bench.run(0.2)
    assert if1.serial.read() == b"U\r"


@settings(max_examples=60)
@given(st.text(LANGUAGE.replace("[", "").replace("#", ""), max_size=60))
def test_after_any_message_cancel_makes_it_ready(text):
    """Cancel: after any text, `#` CR and a request of the faults make the interface ready."""
    bench = Bench()
    if1 = ready(bench)
    send(bench, if1, text, seconds=4)
    send(bench, if1, "#", seconds=4)
    for question in "FK":
        ask(bench, if1, question, 2)
    if1.serial.read()
    assert ask(bench, if1, "E", 2) == b"C\r"
    before = if1.axes["Z"].position
    send(bench, if1, "@400", "Z9$", seconds=3)
    assert if1.axes["Z"].position == before + 9


@pytest.mark.parametrize("moment", [n * 0.0137 for n in range(80)])
def test_power_may_fail_at_any_moment_of_a_message(moment):
    """The power may fail during reception, calculation of a ramp, motion, an output pulse, a reversal or an answer."""
    bench = Bench()
    if1 = ready(bench, "U62", line="1200 8N2", recalculation_s=0.1)
    write(if1, "B-9^20", "X20@500BP1,9$", "K")
    bench.run(moment)
    if1.power(False)
    stopped = if1.axes["X"].position
    bench.run(1)
    if1.serial.read()
    bench.run(1)
    assert if1.serial.read() == b"" and if1.axes["X"].position == stopped
    assert not if1.pins["output1"].level and not if1.serial.dtr
    if1.power(True)
    initialise(bench, if1)
    play(bench, if1, f"K: 0; X5B$; 1 s; X at {stopped + 5}")  # backlash is 0 again, speed 400


@pytest.mark.parametrize("message", [
    "X" * 63, "$" * 60, "X1" * 30, "9" * 60, "@" + "9" * 58, "X" + "9" * 58 + "$", ">" * 50, "S" + "1" * 50 + "$",
    "H" + "1" * 40 + "X5$", "P1," + "0" * 40 + "5$", "B-" + "0" * 40 + "5", "+-" * 30, "///", "X/X$", "X/$", "/X$",
    "X/Y/Z$", "XX5$", "X5X6$", "X--5$", "X+-5$", "G", "A$", "=1,1$", "%$", "KK", "KE", "K$", "EX5$", "X5$E", "[$",
    "]]", "\x00", "\x7f", "\x1b[A", "\x13", "\x11", "X5\x00$", ",", "P,$", "P1,2,3$", "X5,6$", "HL$", "HLX$",
    "H1HL1X5$"])  # fmt: skip
def test_odd_orders(bench, if1, message):
    """R7: no part of a wrong message is executed, and the next message is executed."""
    command(bench, if1, message, seconds=5)
    play(bench, if1, "#; 0.5 s; F?; K?; Y9@400$; 0.5 s; E: C; Y at 9")


def test_a_flood_does_no_harm_and_leaves_no_trace_after_cancel(bench, if1):
    """A flood sets only F 8 (buffer overflow); after cancel the interface works as before."""
    if1.serial.write(bytes(range(256)) * 40)
    bench.run(20)
    command(bench, if1, "#", seconds=3)
    for question in "]FK":
        ask(bench, if1, question, 1)
    assert ask(bench, if1, "E") == b"C\r"
