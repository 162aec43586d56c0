"""Random hosts that keep the handshake, while pins change and time passes; each run is repeated on a new bench."""

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from axistwin import Bench

from .programs import continuous, relative
from .talking import CONTROL, DATA, FAIL, INPUT_READY, MESSAGE, TAKEN, i32

NUMBERS = st.integers(1, 3)
VELOCITIES = st.sampled_from([200, 5_000, 40_000, 500_000])
ACCELERATIONS = st.sampled_from([2_000, 100_000, 20_000_000, 0x7FFF_FFFF])
DISTANCES = st.integers(-4_000, 4_000)

MOVES = st.one_of(
    st.builds(relative, NUMBERS, VELOCITIES, ACCELERATIONS, DISTANCES),
    st.builds(continuous, NUMBERS, VELOCITIES, ACCELERATIONS, st.integers(0, 1)),
    st.builds(lambda v, a: (0x31, 0, 0, *i32(v), *i32(a)), VELOCITIES, ACCELERATIONS),
    st.builds(lambda s: (0xD6, *i32(s)), st.sampled_from([0, 1_000])),
    st.builds(lambda n: (0x40, n), NUMBERS),
    st.builds(lambda d: (0x33, *i32(d)), DISTANCES),
    st.builds(lambda d: (0x34, *i32(d)), DISTANCES),
    st.builds(lambda s: (0x32, s), st.integers(0, 1)),
)
ENDS = st.one_of(
    st.sampled_from([(c,) for c in (0x70, 0x71, 0x72, 0x73, 0x78, 0x79, 0x7A, 0x48, 0xAF)]),
    st.builds(lambda c, t, on, m: (c, t, on, m),
              st.sampled_from([0x74, 0x75, 0x76, 0x77, 0x7C, 0x7D, 0x7E]), st.sampled_from([1, 6]), st.integers(0, 1),
              st.integers(0, 1)),
    st.builds(lambda t, on: (0xAC, t, on), st.sampled_from([1, 6]), st.integers(0, 1)),
    st.builds(lambda c, on: (c, on), st.sampled_from([0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA8, 0xAB]), st.just(1)),
)  # fmt: skip
OTHERS = st.one_of(
    st.sampled_from([(c,) for c in (0x00, 0x10, 0x11, 0x30, 0x84, 0x85, 0x86, 0x89, 0x90, 0x93, 0x97, 0xE2)]),
    st.builds(lambda c, x: (c, x), st.sampled_from([0x01, 0x0D, 0x12, 0x13]), st.integers(0, 1)),
    st.builds(lambda n: (0x91, n), NUMBERS),
    st.builds(lambda n: (0x41, n), NUMBERS),
    st.builds(lambda n: (0xDA, n), NUMBERS),
)
STEPS = st.one_of(
    MOVES,
    st.builds(lambda x, y: (0x20, x, 0, y), st.integers(1, 3), st.integers(1, 4)),
    st.builds(lambda x: (0x21, x), st.integers(1, 3)),
    st.builds(lambda m: (0x28, m), st.integers(0, 1)),
    st.builds(lambda t: (0x29, 0, 0, 0, t), st.integers(1, 200)),
    st.builds(lambda t, high: (0x2C, t, high), st.integers(1, 6), st.integers(0, 1)),
    st.builds(lambda x: (0x01, x), st.integers(0, 255)),
)  # fmt: skip
PINS = [
    *(f"trigger{n}" for n in range(1, 7)), "cw_limit", "ccw_limit", "shutdown_in", "at_zero", "step_in", "direction_in",
]  # fmt: skip


class Tape:
    """A board with a record of actions and observations; a repetition must give the same observations."""

    def __init__(self):
        self.bench = Bench()
        self.board = self.bench.add("1811")
        self.acts = []
        self.seen = []

    def do(self, what, *how):
        self.acts.append((what, how))
        self.seen.append(seen := getattr(self, what)(*how))
        return seen

    def run(self, microseconds):
        self.bench.run(microseconds / 1_000_000)
        return self.board.axes["motor"].pulses, self.board.bus.interrupt

    def write(self, offset, value):
        self.board.bus.write(offset, value)

    def read(self, offset):
        return self.board.bus.read(offset)

    def drive(self, pin, level):
        self.board.pins[pin].drive(level)

    def again(self):
        other = Tape()
        for what, how in self.acts:
            other.do(what, *how)
        return other


class Host(RuleBasedStateMachine):
    """A host that keeps the handshakes and a copy of the control byte, as the manual's programs do."""

    @initialize(ccw_is_plus=st.booleans())
    def begin(self, ccw_is_plus):
        self.tape = Tape()
        self.enabled = 0
        self.heard = []
        self.tape.do("run", 1_010_000)
        self.send(0x14, int(ccw_is_plus))
        self.sign = -1 if ccw_is_plus else 1
        self.origin = 0
        self.define_moves()

    def define_moves(self):
        """Define some moves, as most hosts do first."""
        self.send(*relative(1, 40_000, 20_000_000, 900))
        self.send(*relative(2, 5_000, 100_000, -700))
        self.send(*continuous(3, 5_000, 100_000))
        self.send(0x31, 0, 0, *i32(40_000), *i32(100_000))

    @property
    def status(self):
        return self.tape.do("read", CONTROL)

    def wait(self, bit, times):
        for _ in range(times):
            if self.status & bit:
                return True
            self.tape.do("run", 500)
        return False

    def send(self, *command):
        assert self.wait(INPUT_READY, 400), "SB bit 4 is not set in time"
        for value in command:
            self.tape.do("write", DATA, value)
        self.tape.do("write", CONTROL, 0x10 | self.enabled)

    def message(self, times):
        if not self.wait(MESSAGE, times):
            return b""
        data = bytes(self.tape.do("read", DATA) for _ in range(16))
        self.tape.do("write", CONTROL, TAKEN | self.enabled)
        self.heard.append(data)
        return data

    def ask(self, opcode):
        """Send a request and return its reply; messages before the reply are discarded."""
        self.send(opcode)
        for _ in range(80):
            data = self.message(100)
            assert data, f"no reply to {opcode:02x}"
            if data[0] == opcode:
                return data
        raise AssertionError(f"a flood of messages before the reply to {opcode:02x}")

    @property
    def moving(self):
        return self.tape.board.axes["motor"].velocity != 0

    @property
    def net(self):
        return self.sign * self.tape.board.axes["motor"].pulses - self.origin

    @rule(command=st.one_of(MOVES, MOVES, ENDS, OTHERS))
    def command(self, command):
        self.send(*command)

    @rule(number=NUMBERS, steps=st.lists(STEPS, min_size=1, max_size=5))
    def define_a_sequence(self, number, steps):
        for command in ((0xD9, number), *steps, (0xD8,)):
            self.send(*command)

    @rule(microseconds=st.sampled_from([1, 100, 700, 2_000, 9_000, 50_000, 400_000]))
    def time_passes(self, microseconds):
        self.tape.do("run", microseconds)

    @rule(number=NUMBERS)
    def move(self, number):
        self.send(0x40, number)
        self.tape.do("run", 30_000)

    @rule()
    def clear_of_the_limits(self):
        for pin in ("cw_limit", "ccw_limit"):
            self.tape.do("drive", pin, False)

    @rule(pin=st.sampled_from(PINS), level=st.booleans())
    def a_pin_changes(self, pin, level):
        self.tape.do("drive", pin, level)

    @rule()
    def read_a_message(self):
        self.message(1)

    @rule(on=st.booleans())
    def mask_interrupts(self, on):
        self.enabled = 0x40 if on else 0
        self.tape.do("write", CONTROL, self.enabled)

    @rule(bits=st.integers(0, 7))
    def user_bits_are_seen(self, bits):
        self.send(0x08, bits)
        self.tape.do("run", 300_000)  # sixteen waiting commands take 15 ms each to calculate
        assert self.status & 7 == bits

    @rule()
    def the_position_from_home_is_the_net_count(self):
        """82h: no search is made in these runs, so positions from HOME count from the last reset."""
        before, since = self.net, self.tape.bench.now
        reply = int.from_bytes(self.ask(0x82)[1:7], "big", signed=True)
        issued = len(self.tape.board.axes["motor"].pulse_times(since))
        assert abs(reply - before) <= issued and abs(reply - self.net) <= issued

    @rule()
    def the_status_of_the_motor_is_the_motors(self):
        """88h: at most one of constant, accelerating, decelerating is reported, and at rest none."""
        status = self.ask(0x88)[1]
        assert (status >> 5).bit_count() <= 1
        assert bool(status & 0x10) or not status & 0xE0, "a motor at rest has no velocity and no ramp"

    @precondition(lambda self: not self.moving)
    @rule()
    def killed_it_rests_where_it_says(self):
        """After 10h, 79h and 78h nothing moves, and all reported positions agree with the pulses."""
        for opcode in (0x10, 0x79, 0x78):
            self.send(opcode)
        self.tape.do("run", 40_000)
        if self.moving:
            return  # the move of a command or a pin that came earlier
        assert int.from_bytes(self.ask(0x82)[1:7], "big", signed=True) == self.net
        first = self.ask(0x83)[1:7]
        self.tape.do("run", 10_000)
        assert self.ask(0x83)[1:7] == first

    @rule()
    def reset(self):
        self.tape.do("write", CONTROL, 0x20)
        self.enabled = 0
        self.tape.do("run", 1_010_000)
        assert self.status == 0x50
        self.sign = 1
        self.origin = self.tape.board.axes["motor"].pulses
        assert int.from_bytes(self.ask(0x82)[1:7], "big", signed=True) == 0
        self.define_moves()

    @invariant()
    def the_status_byte_is_consistent(self):
        if not hasattr(self, "tape"):
            return
        status, interrupt = self.status, self.tape.board.bus.interrupt
        assert not status & FAIL and bool(status & 0x40) is not bool(self.enabled)
        assert interrupt is bool(self.enabled and status & MESSAGE)
        assert status & 0x80 or not interrupt

    @invariant()
    def messages_are_those_of_commands(self):
        known = {0x01, 0x28, *range(0x74, 0x80), *range(0x80, 0x98), *range(0xA0, 0xAD), 0xE2}
        for data in getattr(self, "heard", []):
            assert data[0] in known

    def teardown(self):
        if hasattr(self, "tape"):
            assert self.tape.again().seen == self.tape.seen, "the same acts, another course"


Host.TestCase.settings = settings(
    max_examples=15,
    stateful_step_count=30,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
TestHost = Host.TestCase
