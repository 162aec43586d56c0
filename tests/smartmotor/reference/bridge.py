"""Convert the reference's state to the processor's arrays, and run the kernel on these arrays."""

from string import ascii_lowercase
from struct import unpack

from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel import jit, kernel, state
from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.language.program import Program

from .motor import FLAGS, PINS
from .program import no_value

MODES = {
    "off": state.M_OFF, "brake": state.M_BRAKE, "error": state.M_ERROR, "hold": state.M_HOLD,
    "position": state.M_POSITION, "velocity": state.M_VELOCITY, "torque": state.M_TORQUE, "stop": state.M_STOP,
    "follow": state.M_FOLLOW, "ratio": state.M_RATIO, "step": state.M_STEP, "step ratio": state.M_STEP_RATIO,
    "cam": state.M_CAM, "host": state.M_HOST,
}  # fmt: skip
REASONS = {
    "statement": kernel.STATEMENT_WAITS, "value": kernel.VALUE_WAITS, "call": kernel.CALL_WAITS,
    "trajectory": kernel.TRAJECTORY, "plus": kernel.PLUS, "minus": kernel.MINUS, "error": kernel.ERROR,
    "heat": kernel.HEAT, "go": kernel.GO_EDGE, "switch": kernel.SWITCH, "index": kernel.INDEX_MARK,
    "taken": kernel.PIN_TAKEN,
    "exit": kernel.HOST_EXIT, "underflow": kernel.HOST_UNDERFLOW, "last": kernel.HOST_LAST,
}  # fmt: skip
CALLS = {"GOSUB": state.CALL_GOSUB, "C1": state.CALL_FAULT, "C2": state.CALL_INPUT}
OPERATIONS = {
    "if": ops.S_IF, "while": ops.S_IF, "leave": ops.S_JUMP, "loop": ops.S_JUMP, "skip": ops.S_JUMP,
    "switch": ops.S_SWITCH, "case": ops.S_CASE, "end of text": ops.S_END, "let": ops.S_LET, "element": ops.S_ELEMENT,
    "WAIT": ops.S_WAIT, "TWAIT": ops.S_TWAIT, "BREAK": ops.S_JUMP, "RETURN": ops.S_RETURN, "RETURNF": ops.S_RETURN,
    "RETURNI": ops.S_RETURNI, "STACK": ops.S_STACK, "END": ops.S_END,
}  # fmt: skip
VARIABLES = [letter * n for n in (1, 2, 3) for letter in ascii_lowercase]
POINTS = 16
SAMPLES = 512


def integers(motor):
    """Return slots of `i` and their values, except places in the code."""
    shown = {getattr(state, name): value for name, value in motor.values.items() if not name.startswith("U")}
    for part in (_time, _program, _trajectory, _host, _follow, _cam, _servo, _protection, _inputs):
        shown |= part(motor)
    return {slot: int(value) for slot, value in shown.items()}


def _time(motor):
    return {state.SAMPLE: motor.sample_number, state.CLK_ZERO: motor.clock_zero, state.PID_RATE: motor.rate}


def _program(motor):
    runner = motor.runner
    states = {"stopped": state.STOPPED, "running": state.RUNNING}
    return {
        state.PROGRAM: states[runner.state], state.STATEMENT: runner.number, state.BUDGET: runner.left,
        state.STATEMENTS_PER_SAMPLE: motor.per_sample, state.WAIT_UNTIL: runner.wait_until,
        state.DEPTH: len(runner.returns), state.TWAITING: runner.held, state.C2_CALLED: runner.c2_called,
        state.FAULT_AGAIN: runner.fault_again, state.PENDING: sum(CALLS[why] for why in runner.pending),
        state.ARRAY_BASE: state.DOUBLES if motor.overlay else state.ALONE,
    } | {state.SWITCHES + depth: value for depth, value in enumerate(runner.switches)}  # fmt: skip


def _trajectory(motor):
    trajectory = motor.trajectory
    return {
        state.MODE: MODES[trajectory.mode], state.COMMANDED: trajectory.place, state.VELOCITY: trajectory.velocity,
        state.TARGET: trajectory.target, state.MAX_VELOCITY: trajectory.top, state.ACCELERATION: trajectory.rate,
        state.FACTOR: trajectory.factor, state.FOLLOW_REM: trajectory.owed * trajectory.target,
        state.SHAFT: motor.shaft, state.DIRECTION: motor.direction, state.ORIGIN: motor.origin,
    }  # fmt: skip


def _host(motor):
    host = motor.host
    return {
        state.HOST_HEAD: 2 * host.passed % (2 * POINTS), state.HOST_COUNT: len(host.points), state.HOST_LEFT: host.left,
        state.HOST_CLOCK: host.clock, state.HOST_STARTED: host.started, state.HOST_SIZE: 2 * POINTS,
    }  # fmt: skip


def _follow(motor):
    master, run = motor.master, motor.master.run
    denominator = run.rate.denominator * run.ahead.denominator
    return {
        state.CTR: master.ctr, state.MASTER: master.edges, state.MASTER_SEEN: master.seen,
        state.SHOWN: sum(1 << PINS.index(pin) for pin in master.shown), state.PIN_EDGES: master.by_hand,
        state.STEP_UP: master.up, state.STEPS: master.steps, state.RESOLUTION: master.resolution,
        state.MASTER_WAY: run.way, state.MASTER_STEP: run.rate // 1, state.MASTER_ADD: run.rate % 1 * denominator,
        state.MASTER_DIV: denominator, state.MASTER_REM: run.turned % 1 * denominator, state.MASTER_LEFT: run.left,
        state.MASTER_END: run.end,
    }  # fmt: skip


def _cam(motor):
    cam, now, prepared = motor.cam, motor.cam.now, motor.cam.prepared
    return {
        state.CAM_PHASE: cam.phase, state.CAM_ORIGIN: cam.origin, state.CX: cam.index,
        state.CAM_BASE: now.base, state.CAM_SIZE: now.size, state.CAM_DWELL: now.dwell, state.CAM_F: now.word,
        state.CAM_FACTOR: now.factor, state.MC_BASE: prepared.base, state.MC_SIZE: prepared.size,
        state.MC_FACTOR: prepared.factor, state.D: prepared.dwell, state.F: prepared.word,
        state.CI_PENDING: cam.pending, state.CAM_TABLE: cam.table_factor,
    }  # fmt: skip


def _servo(motor):
    law, heat = motor.law, motor.machine.temperatures
    shown = {
        state.DRIVE: motor.drive, state.BRAKE: motor.machine.brake, state.T: motor.torque, state.AMPS: motor.amps,
        state.IDEAL: motor.data is None, state.TH: motor.hot_limit[0], state.THD: motor.hot_limit[1],
        state.PWM: law.pwm, state.INTEGRAL: law.integral, state.ERROR_BEFORE: law.error_before,
        state.DIFFERENCE: law.difference, state.VELOCITY_BEFORE: law.velocity_before,
        state.TEMP: heat.housing // 1, state.HOT: heat.hot, state.OVERLOAD: heat.overload,
    }  # fmt: skip
    shown |= {state.TUNING + n: value for n, value in enumerate(law.tuning)}
    if motor.data:
        current = motor.machine.current
        shown |= {state.CURRENT_SUM: current.filtered, state.CURRENT: current.filtered // 16}
        shown |= {state.HEAT: sum(current.squares), state.HEAT_SAMPLES: len(current.squares)}
    return shown


def _protection(motor):
    return {getattr(state, flag.upper()): value for flag, value in motor.flags.items()} | {
        state.E: motor.error_limit, state.SOFT_LIMITS: motor.soft_limits, state.STOPPING: motor.stopping,
        state.SLP: motor.plus.soft, state.SLN: motor.minus.soft, state.LIMIT_C: motor.plus.has_pin,
        state.LIMIT_D: motor.minus.has_pin, state.ACKNOWLEDGED_PLUS: motor.plus.acknowledged,
        state.ACKNOWLEDGED_MINUS: motor.minus.acknowledged,
    }  # fmt: skip


def _inputs(motor):
    index, go = motor.index, motor.go
    analog = {state.ANALOG + n: motor.values.get(f"U{pin}A", 0) for n, pin in enumerate(PINS)}
    return analog | {
        state.PINS: sum(level << bit for bit, level in enumerate(motor.pins.values())), state.GO_LEVEL: go.level,
        state.BRAKE_PIN: 1 << PINS.index(motor.brake_pin) if motor.brake_pin else 0, state.BRAKE_READ: motor.brake_read,
        state.GO_COUNT: go.different, state.DEBOUNCE: go.debounce, state.WINDOW_LOW: motor.window[0],
        state.WINDOW_HIGH: motor.window[1], state.INDEX: index.position, state.INDEX_ARMED: index.armed,
        state.INDEX_FORCED: index.forced, state.INDEX_LOW: index.below, state.INDEX_HIGH: index.below + index.turn,
        state.COUNTS_PER_REV: index.turn,
    }  # fmt: skip


def variables(motor):
    """Return all values of `v`."""
    memory, longs = motor.memory, unpack(">51i", motor.memory.bytes)
    named = [memory.named.get(name, 0) for name in VARIABLES]
    if motor.overlay:  # aa…zz and aaa…yyy are al[0]…al[50]
        named[26:77], longs = longs, [0] * 51
    return [*named, *longs, motor.fetched, *[0] * (state.HIDDEN_MOST - 1)]


def floats(motor):
    """Return the slots of `f` that a sample changes, with their values."""
    if not motor.data:
        return {}
    shaft, heat = motor.machine, motor.machine.temperatures
    return {
        machine.AMPS_NOW: shaft.amps,
        machine.SPEED: shaft.speed, machine.FRACTION: shaft.fraction, machine.WINDING_C: heat.winding,
        machine.HOUSING_C: heat.housing, machine.MEAN_SQUARE: heat.mean_square,
    }  # fmt: skip


def shown(motor):
    """Return `integers`, `variables` and `floats` of the reference."""
    return integers(motor), variables(motor), floats(motor)


def step(motor, step):
    """Return a step of the reference as the head of a statement in the code: operation and number."""
    if step is None:
        return None
    number = step.number(motor.program)
    if step.fetch:
        return ops.S_FETCH, number
    if step.what == "case" and step.node.parts[step.part].value is no_value:
        return ops.S_IF, number
    if step.what != "do":
        return OPERATIONS[step.what], number
    word = step.node.keyword
    if word.startswith(("GOTO", "GOSUB")) and int(word.lstrip("GOTSUB")) in motor.program.labels:
        return (ops.S_JUMP if word.startswith("GOTO") else ops.S_GOSUB), number
    return OPERATIONS.get(word, ops.S_TRAP), number


class Kernel:
    """The kernel on arrays that hold the state of the reference."""

    def __init__(self, motor, text, *, compiled=False):
        self.program = Program.compile(text)
        self.i, self.v, self.f = [0] * state.INTS, [0] * state.VARIABLES, [0.0] * machine.FLOATS
        self.ring, self.stack, self.code = [0] * 2 * POINTS, [0] * ops.STACK, list(self.program.code)
        self.shaft, self.commanded, self.log, self.told = [0] * SAMPLES, [0] * SAMPLES, [0] * 3, [0]
        machine.fit(self.i, self.f, motor.data, motor.load)
        self._advance = kernel.advance
        if compiled:
            self._compile()
        self.take(motor, shown(motor))

    def _compile(self):
        import numpy as np

        self._advance = jit.best(kernel.advance)
        for name in ("i", "v", "ring", "stack", "code", "told", "shaft", "commanded", "log"):
            setattr(self, name, np.array(getattr(self, name), dtype=np.int64))
        self.f = np.array(self.f)

    def take(self, motor, what):
        """Set the kernel's arrays to the state of the reference; `what` is `shown(motor)`."""
        whole, self.v[:], parts = what
        for slot, value in whole.items():
            self.i[slot] = value
        for slot, value in parts.items():
            self.f[slot] = value
        for n, (position, clock) in enumerate(motor.host.points, motor.host.passed):
            at = 2 * (n % POINTS)
            self.ring[at], self.ring[at + 1] = position, clock
        if motor.data:
            machine.set_torque(self.f, motor.machine.torque_nm)
            self.f[machine.AMBIENT] = motor.machine.ambient
        machine.set_jam(self.f, motor.machine.jammed)

    def advance(self, most):
        """Advance by up to `most` samples; return the reason to stop as a number, and the positions."""
        first = int(self.i[state.SAMPLE])
        why = self._advance(
            self.i, self.v, self.f, self.stack, self.code, self.ring, self.told,
            self.shaft, self.commanded, self.log, most,
        )  # fmt: skip
        done = int(self.i[state.SAMPLE]) - first
        return why, list(self.shaft[:done]), list(self.commanded[:done])

    def place(self, place):
        """Return operation and number at a place in the code."""
        return None if place < 0 else (int(self.code[place]), int(self.code[place + 1]))

    def compare(self, motor, what):
        whole, named, parts = what
        i = list(map(int, self.i))
        differences = {NAMES.get(slot, slot): (i[slot], value) for slot, value in whole.items() if i[slot] != value}
        assert not differences, f"kernel, reference: {differences}"
        assert list(map(int, self.v)) == named
        for slot, value in parts.items():
            assert float(self.f[slot]) == value
        assert self.place(i[state.PC]) == step(motor, motor.runner.step)
        for n, (back, why) in enumerate(motor.runner.returns):
            word = i[state.RETURNS + n]
            assert (self.place(word >> 2), word & 3) == (step(motor, back), CALLS[why])


NAMES = {value: name for name, value in reversed(vars(state).items()) if name.isupper() and isinstance(value, int)}
assert {getattr(state, flag.upper()) for flag in FLAGS} == set(state.STATUS)
