"""Protocol core of the Digiplan IF1 and IF2.

The controller has no position: it counts the steps of the last index or run (`N`).  The core adds these counts.  The
position is known as long as no other host moves an axis and the power stays on.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from axistwin.drivers.axis import Fault, Status
from axistwin.drivers.core import AxisCore, Core, Line, shown
from axistwin.drivers.errors import BusyError, RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.estimate import Trapezoid
from axistwin.drivers.steps import Clock, Pause, Procedure, Write

MOVING, AT_SPEED, DRIVE, ESTOP, LIMIT, COMMUNICATION = 1, 2, 16, 32, 64, 128
I_ESTOP, I_X_FAULT, I_Y_FAULT, I_INPUT_1, I_PLUS, I_MINUS, I_INPUT_2, I_INPUT_3 = 1, 2, 4, 8, 16, 32, 64, 128
I_INPUTS = {1: I_INPUT_1, 2: I_INPUT_2, 3: I_INPUT_3}
READING_ERROR = 256
"""Largest error, in steps, of a step count that is read during motion."""
CHUNK = 32
"""Number of characters sent at once; the input buffer of the controller holds 64."""
START_POLLS = 5
STARTUP_TRIES, STARTUP_S = 6, 0.5
MAX_DISTANCE = 999_999_999
MAX_SPEED = {1: 25_000, 2: 50_000, 3: 100_000, 4: 4_000}
_ANSWER = re.compile(rb"(I\r\n?)?\s*(\d+)\r(\n?)$")

FAULTS = {
    DRIVE: Fault("drive fault", "check the drive, then call clear_faults and set_position"),
    ESTOP: Fault("emergency stop", "release the button, then call clear_faults"),
    LIMIT: Fault("limit", "call clear_faults and move away from the limit"),
}
COMMUNICATION_FAULTS = {
    1: Fault("parity error", "check the line format, then call clear_faults"),
    2: Fault("overrun", "use the echo or a lower baud rate, then call clear_faults"),
    4: Fault("framing error", "check the line format, then call clear_faults"),
    8: Fault("invalid message", "check the command, then call clear_faults"),
    16: Fault("value out of range", "check the command and the speed range, then call clear_faults"),
}


@dataclass
class Move:
    """A commanded motion of one or more axes."""

    signs: dict[str, int]
    """The direction of each axis."""
    distance: int | None
    """Number of steps; None for a run that lasts until `stop`."""
    profile: Trapezoid
    begun: float
    counted: int
    """The step count (N) before the move."""
    seen: int = 0
    """Number of polls before the motion began; `START_POLLS` after the motion has begun."""
    made: float = 0.0
    """Largest estimate so far."""
    homing: bool = False
    stopped: bool = False


@dataclass
class _State:
    positions: dict[str, int]
    lost: dict[str, str] = field(default_factory=dict)
    counted: int = 0
    inputs: int = 0
    latched: int = 0
    communication: int = 0


class IF1(Core):
    """Implements the protocol of an IF1 or IF2; the controller has the three axes X, Y and Z.

    `timeout`: longest wait for an answer; a ramp calculation takes up to 1 s.  `echo`: True if the controller echoes
    each character; the core then checks the echo before the command takes effect.  At 4800 and 9600 baud the echo is
    always on.  `speed_range`: 1 to 4, sets the highest speed.  `start_stop`: start/stop speed in steps/s.
    `home_input`: number of the input with the home switch, 1 to 3.
    """

    line = Line(9600, stop_bits=2)

    def __init__(
        self,
        timeout: float = 2.0,
        *,
        echo: bool = True,
        speed_range: int = 1,
        start_stop: int = 400,
        home_input: int | None = None,
    ) -> None:
        super().__init__(timeout)
        if speed_range not in MAX_SPEED:
            raise ValueError(f"invalid speed_range {speed_range}: expected 1 to 4")
        if home_input not in (None, *I_INPUTS):
            raise ValueError(f"invalid home_input {home_input}: expected 1, 2 or 3")
        self.echo, self.speed_range, self.start_stop, self.home_input = echo, speed_range, start_stop, home_input
        self._linefeed = False
        self._known = False
        self._ramp: float | None = None
        self._move: Move | None = None
        self.axes = {name: IF1Axis(self, name) for name in "XYZ"}
        self._state = _State(dict.fromkeys("XYZ", 0))

    # Synchronisation of the driver with the controller

    def synchronise(self) -> Procedure[None]:
        """Establish communication with the IF1 at the serial port.  Initialise the IF1 if necessary.

        An IF1 needs an initialisation after each power-up.
        """
        yield from self._discard(0.0)
        if (yield from self._probe()):
            yield from self._adopt()
            return
        for _ in range(STARTUP_TRIES):
            yield Write(b"(")
            answer = yield from self._discard(STARTUP_S)
            if answer.endswith(b"U\r"):
                yield from self._initialise()
                return
            if answer:
                raise WrongAnswerError(
                    f"the device answered {shown(answer)} to the request '(': expected the letter U, as from an IF1"
                )
        raise SilentError(f"no IF1 at this port answered the request '(' or the request 'I': {self.remedy}")

    def _probe(self) -> Procedure[bool]:
        """Return True if the controller is initialised.

        Also detect whether the controller echoes characters, and whether a line feed follows CR in its answers.
        """
        for _ in range(2):
            # Try twice, because an incomplete message in the buffer of the IF1 spoils the first request.
            yield Write(b"I\r\n")
            answer = yield from self._discard(min(0.25, self.timeout))
            if found := _ANSWER.search(answer):
                self.echo = found[1] is not None
                self._linefeed = found[1] == b"I\r\n" if self.echo else found[3] == b"\n"
                return True
        return False

    def _initialise(self) -> Procedure[None]:
        """Set the data format and the speed range after a power-up of the controller."""
        self._linefeed = False
        if self._known:
            self._lose("XYZ", "the power of the IF1 was cut")
        self._move, self._ramp = None, None
        yield Write(b"U62\r" if self.echo else b"U61\r")
        yield Pause(0.01)
        yield from self._number("I")
        yield from self._configure()
        self._state.counted = yield from self._number("N")
        self._known = True

    def _adopt(self) -> Procedure[None]:
        """Read the state of a controller that is already initialised."""
        # The status request F clears the data fault that an incomplete message has caused.
        yield from self._number("F")
        if self._known:
            yield from self._poll()
            return
        bits = yield from self._motion()
        if bits & MOVING:
            self._lose("XYZ", "the IF1 was moving when the driver connected")
        else:
            yield from self._configure()
        self._state.counted = yield from self._number("N")
        self._known = True

    def _configure(self) -> Procedure[None]:
        acceleration = max(axis.acceleration for axis in self.axes.values())
        yield from self._set_ramp(acceleration)

    def _set_ramp(self, acceleration: float) -> Procedure[None]:
        """Send a new acceleration, with the speed range and the start/stop speed.

        Send nothing if the acceleration has not changed.
        """
        thousands = min(max(round(acceleration / 1000), 1), 500)
        if self._ramp != thousands:
            hundreds = min(max(round(self.start_stop / 100), 1), 40)
            yield from self.message(f">{self.speed_range}<{hundreds}^{thousands}")
            self._ramp = thousands

    def _lose(self, axes: Iterable[str], why: str) -> None:
        # If an axis has already lost its position, keep the stored reason for the loss.
        self._state.lost = dict.fromkeys(axes, why) | self._state.lost

    # Messages

    def message(self, text: str) -> Procedure[None]:
        """Send a message and a terminator.

        If the controller echoes characters, send the terminator only after the correct echo of the message.
        """
        data = text.encode("ascii")
        for begin in range(0, len(data), CHUNK):
            part = data[begin : begin + CHUNK]
            yield Write(part)
            if not self.echo:
                yield Pause(0.0 if begin + CHUNK >= len(data) else 0.05)
            elif (echo := (yield from self._take(len(part), text))) != part:
                yield Write(b"#\r")
                raise WrongAnswerError(
                    f"the IF1 returned the wrong echo {shown(echo)} for the message {text}: check the line for noise"
                )
        end = b"\r\n" if self._linefeed else b"\r"
        yield Write(end)
        if self.echo and (echo := (yield from self._take(len(end), text))) != end:
            raise WrongAnswerError(
                f"the IF1 returned the wrong echo {shown(echo)} after the message {text}: check the line for noise"
            )

    def _number(self, request: str) -> Procedure[int]:
        """Send a status request and return the number in the answer."""
        yield from self.message(request)
        answer = (yield from self._until(b"\r", request)).strip()
        if self._linefeed:
            yield from self._until(b"\n", request)
        if not answer.isdigit():
            raise WrongAnswerError(
                f"the IF1 answered {shown(answer)} to the status request {request}: expected a whole number, e.g. 16"
            )
        return int(answer)

    def _motion(self) -> Procedure[int]:
        """Read the controller's motion status, and store the faults that the status reports.

        The controller clears these faults when they are read.
        """
        bits = yield from self._number("K")
        self._state.latched |= bits & (DRIVE | ESTOP | LIMIT | COMMUNICATION)
        if bits & COMMUNICATION:
            self._state.communication |= yield from self._number("F")
        return bits

    # Motion

    def _poll(self) -> Procedure[bool]:
        """Read the state of the controller; return True while a motion is in progress."""
        bits = yield from self._motion()
        steps = yield from self._number("N")
        move = self._move
        if bits & MOVING:
            if move is None:
                self._lose("XYZ", "another host is moving the IF1")
            else:
                move.seen = START_POLLS
                yield from self._estimate(move, steps)
            return True
        if move is not None and move.seen < START_POLLS and steps != move.distance and not bits and not move.stopped:
            move.seen += 1  # The IF1 has not begun the commanded move yet.
            return True
        self._state.inputs = yield from self._number("I")
        self._settle(steps, bits)
        return False

    def _estimate(self, move: Move, steps: int) -> Procedure[None]:
        """Estimate the position during a move from the step count and the elapsed time."""
        now: float = yield Clock()
        expected = steps if move.stopped or move.homing else move.profile.position(now - move.begun)
        near = min(max(expected, steps - READING_ERROR), steps + READING_ERROR)
        most = near if move.distance is None else move.distance
        move.made = max(move.made, min(near, most))

    def _settle(self, steps: int, bits: int) -> None:
        """Add the steps of a completed move to the stored position of each moved axis."""
        state, move = self._state, self._move
        if move is None:
            if steps != state.counted:
                self._lose("XYZ", "another host has moved the IF1")
        elif bits & DRIVE:
            self._lose(move.signs, "a drive fault has interrupted the move")
        elif self._cannot_be_of(move, steps, bits):
            self._lose("XYZ", "another host has moved the IF1, or the move was interrupted as it began")
        else:
            for name, sign in move.signs.items():
                state.positions[name] += sign * steps
        if move is not None and move.homing and not move.stopped and self._at_home():
            for name in move.signs:
                state.positions[name] = self.axes[name].setpoint = 0
                self.axes[name]._aim(None)
                state.lost.pop(name, None)
        state.counted, self._move = steps, None

    def _at_home(self) -> bool:
        return self.home_input is not None and not self._state.inputs & I_INPUTS[self.home_input]

    @staticmethod
    def _cannot_be_of(move: Move, steps: int, bits: int) -> bool:
        if move.distance is not None and steps > move.distance:
            return True
        return bool(bits & (ESTOP | LIMIT)) and steps == move.counted != 0

    def begin(self, signs: dict[str, int], distance: int | None, speed: float, text: str) -> Procedure[Move]:
        """Begin a motion.  Raises RefusedError if the controller does not accept the message."""
        yield from self._ready_for(set(signs.values()))
        counted = self._state.counted
        for name, sign in signs.items():
            target = None if distance is None else self._state.positions[name] + sign * distance
            self.axes[name]._aim(target, faults=self._faults())
        yield from self.message(text)
        acceleration = (self._ramp or 1) * 1000.0
        profile = Trapezoid(speed, acceleration, distance)
        self._move = Move(signs, distance, profile, (yield Clock()), counted)
        bits = yield from self._motion()
        if self._state.communication and not bits & MOVING:
            self._move = None
            for name in signs:
                self.axes[name]._aim(None)
            fault = self._communication_faults()[0]
            self._state.communication, self._state.latched = 0, self._state.latched & ~COMMUNICATION
            raise RefusedError(f"the IF1 refused the message {text} ({fault.name}): {fault.remedy}")
        return self._move

    def _ready_for(self, directions: set[int]) -> Procedure[None]:
        if (yield from self._poll()):
            raise BusyError(
                "the IF1 is moving, so no other move can begin: wait for the end of the motion, or stop the axes"
            )
        state = self._state
        for bit, active in ((ESTOP, I_ESTOP), (DRIVE, I_X_FAULT | I_Y_FAULT)):
            if state.latched & bit or state.inputs & active:
                fault = FAULTS[bit]
                raise RefusedError(f"the IF1 does not move because of a fault ({fault.name}): {fault.remedy}")
        for direction, bit, sign in ((1, I_PLUS, "+"), (-1, I_MINUS, "-")):
            if state.inputs & bit and direction in directions:
                raise RefusedError(f"the {sign} limit is active: move in the other direction")
        if state.latched & LIMIT:
            fault = FAULTS[LIMIT]
            raise RefusedError(f"the IF1 does not move because of a fault ({fault.name}): {fault.remedy}")

    def stop(self) -> Procedure[None]:
        """Decelerate all axes to a standstill, and end the running sequence, if any."""
        for axis in self.axes.values():
            axis._aim(None)
        yield from self.message("#")
        if self._move is not None:
            self._move.stopped = True

    def status_of(self, axis: "IF1Axis") -> Procedure[Status]:
        """Return the state of an axis."""
        return self._status(axis, (yield from self._poll()))

    def statuses(self) -> Procedure[dict[str, Status]]:
        """Read the controller once, and return the state of each axis; positions are in steps."""
        moving = yield from self._poll()
        return {name: self._status(axis, moving) for name, axis in self.axes.items()}

    def _status(self, axis: AxisCore, moving: bool) -> Status:
        state, move = self._state, self._move
        position, velocity, mine = float(state.positions[axis.name]), 0.0, False
        if moving and move is not None and axis.name in move.signs:
            mine = True
            position += move.signs[axis.name] * move.made
            velocity = move.signs[axis.name] * move.profile.velocity
        return axis._judged(
            Status(
                position,
                axis.setpoint,
                velocity,
                mine,
                mine,
                bool(state.inputs & I_PLUS),
                bool(state.inputs & I_MINUS),
                self._at_home(),
                self._faults(),
                state.lost.get(axis.name, ""),
            )
        )

    def _faults(self) -> tuple[Fault, ...]:
        found = [fault for bit, fault in FAULTS.items() if self._state.latched & bit]
        return (*found, *self._communication_faults())

    def _communication_faults(self) -> list[Fault]:
        return [fault for bit, fault in COMMUNICATION_FAULTS.items() if self._state.communication & bit]

    def clear_faults(self) -> Procedure[None]:
        """Clear the faults whose cause no longer exists."""
        yield from self._poll()
        self._state.latched, self._state.communication = 0, 0
        yield from self._poll()

    def set_position(self, name: str, position: int) -> Procedure[None]:
        """Set the present position of an axis to a new value without a move; all axes must be at rest."""
        if (yield from self._poll()):
            raise BusyError("the IF1 is moving: the position can only be set at rest")
        self._state.positions[name] = self.axes[name].setpoint = position
        self.axes[name]._aim(None)
        self._state.lost.pop(name, None)

    def position_of(self, name: str) -> int:
        """Return the position of an axis at rest.  Raises PositionLostError if the position is not known."""
        return round(
            Status(self._state.positions[name], 0, 0, False, lost=self._state.lost.get(name, "")).known_position()
        )

    # Functions that only the controllers IF1 and IF2 have

    def move_together(self, targets: Mapping[str, int]) -> Procedure[None]:
        """Begin a move of two or three axes to target positions.  All axes must have equal distances to their targets.

        Raises RefusedError if the distances in steps are not equal.
        """
        if (yield from self._poll()):
            raise BusyError("the IF1 is moving: wait for the end of the motion, or stop the axes")
        distances = {name: target - self.position_of(name) for name, target in targets.items()}
        lengths = {abs(distance) for distance in distances.values()}
        if len(lengths) != 1:
            raise RefusedError(f"unequal distances {distances}: expected equal distances for axes that move together")
        signs = {name: 1 if distance >= 0 else -1 for name, distance in distances.items()}
        axis = self.axes[next(iter(targets))]
        yield from self._set_ramp(axis.acceleration)
        distance, speed = lengths.pop(), self.speed(axis.velocity)
        if distance:
            words = "".join(f"{name}{'+' if sign > 0 else '-'}" for name, sign in signs.items())
            yield from self.begin(signs, distance, speed, f"{words}{distance}@{speed}$")
        for name, target in targets.items():
            self.axes[name].setpoint = self.axes[name].target = target

    def speed(self, wanted: float) -> int:
        """Return a speed rounded to whole steps/s.  Raises RefusedError if the speed is outside the speed range."""
        highest = MAX_SPEED[self.speed_range]
        if not 0.5 <= wanted <= highest:
            raise RefusedError(
                f"invalid speed {wanted:g} steps/s: expected 1 to {highest} steps/s in speed range {self.speed_range}"
            )
        return max(round(wanted), 1)

    def inputs(self) -> Procedure[dict[int, bool]]:
        """Return the states of the IF1's inputs 1 to 3.

        The state is True if current flows through the input.
        """
        bits = yield from self._number("I")
        return {number: not bits & bit for number, bit in I_INPUTS.items()}

    def outputs(self, on: Iterable[int] = (), off: Iterable[int] = ()) -> Procedure[None]:
        """Switch outputs on and off.

        `on`, `off`: numbers of the outputs, 1 to 5.
        """
        setting, resetting = "".join(map(str, on)), "".join(map(str, off))
        text = (f"S{setting}" if setting else "") + (f"R{resetting}" if resetting else "")
        if text:
            yield from self.message(f"{text}$")

    def sequence(self, steps: Iterable[str]) -> Procedure[None]:
        """Store and start a sequence of commands, e.g. ["H1", "X400@100", "S1"].

        Afterwards, the positions of the axes in the sequence are not known.
        """
        listed = list(steps)
        if (yield from self._poll()):
            raise BusyError("the IF1 is moving: wait for the end of the motion, or stop the axes")
        moved = {name for step in listed for name in "XYZ" if name in step}
        self._lose(moved, "a sequence has moved the IF1")
        for name in moved:
            self.axes[name]._aim(None)
        yield from self.message(":" + ":".join(listed) + ":$")
        self._move = Move({}, None, Trapezoid(1.0, 1.0), (yield Clock()), self._state.counted)

    def busy(self) -> Procedure[bool]:
        """Return True while the controller executes a move, a wait or an output pulse."""
        yield from self.message("E")
        answer = (yield from self._until(b"\r", "E")).strip()
        if self._linefeed:
            yield from self._until(b"\n", "E")
        return answer == b"E"


class IF1Axis(AxisCore):
    """An axis of an IF1."""

    def __init__(self, core: IF1, name: str) -> None:
        super().__init__(name, velocity=1000.0, acceleration=10_000.0, exact=False)
        self._if1 = core
        self.max_velocity = float(MAX_SPEED[core.speed_range])
        self.max_position = MAX_DISTANCE

    def move_to(self, target: int) -> Procedure[None]:
        """Begin a move to a position."""
        core = self._if1
        if (yield from core._poll()):
            raise BusyError(
                "the IF1 is moving, so no other move can begin: wait for the end of the motion, or stop the axes"
            )
        distance, speed = target - core.position_of(self.name), core.speed(self.velocity)
        if abs(distance) > MAX_DISTANCE:
            raise RefusedError(f"the distance of {distance} steps is too long: expected at most 999999999 steps")
        if distance:
            yield from core._set_ramp(self.acceleration)
            sign = 1 if distance > 0 else -1
            text = f"{self.name}{distance:+d}@{speed}$"
            yield from core.begin({self.name: sign}, abs(distance), speed, text)
        self.setpoint = self.target = target

    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a relative move: the new target is the present position plus `distance`."""
        core = self._if1
        if (yield from core._poll()):
            raise BusyError(
                "the IF1 is moving, so no other move can begin: wait for the end of the motion, or stop the axes"
            )
        yield from self.move_to(core.position_of(self.name) + distance)

    def move_at(self, velocity: float) -> Procedure[None]:
        """Run the axis at a signed velocity until `stop` is called."""
        if not velocity:
            yield from self.stop()
            return
        core, speed = self._if1, self._if1.speed(abs(velocity))
        yield from core._ready_for({1 if velocity > 0 else -1})
        yield from core._set_ramp(self.acceleration)
        sign = "+" if velocity > 0 else "-"
        yield from core.begin({self.name: 1 if velocity > 0 else -1}, None, speed, f"{self.name}{sign}@{speed}G$")

    def stop(self) -> Procedure[None]:
        """Decelerate all axes to a standstill."""
        yield from self._if1.stop()

    def abort(self) -> Procedure[None]:
        """Decelerate all axes, as `stop` does, because an IF1 has no faster stop."""
        yield from self._if1.stop()

    def home(self, direction: int) -> Procedure[None]:
        """Move the axis at the start/stop speed to the home switch, and set the axis position to 0."""
        core = self._if1
        if core.home_input is None:
            raise RefusedError("no home switch is configured: expected the option home_input, e.g. home_input=1")
        yield from core._ready_for({direction})
        if not core._state.inputs & I_INPUTS[core.home_input]:
            raise RefusedError(f"home input {core.home_input} is already high: move the axis away from the home switch")
        sign = "+" if direction > 0 else "-"
        text = f":{self.name}{sign}@{core.start_stop}G:H{core.home_input}A:$"
        move = yield from core.begin({self.name: direction}, None, core.start_stop, text)
        move.homing = self._seeking = True

    def status(self) -> Procedure[Status]:
        """Return the state of the axis."""
        return (yield from self._if1.status_of(self))

    def set_position(self, position: int) -> Procedure[None]:
        """Set the present position of the axis to a new value without a move; all axes must be at rest."""
        yield from self._if1.set_position(self.name, position)

    def clear_faults(self) -> Procedure[None]:
        """Clear the faults whose cause no longer exists."""
        yield from self._if1.clear_faults()
