"""Protocol core of the Digiplan IF1 and IF2.

The controller has no position: it counts the steps of the last index or run (`N`).  The core adds these counts.  The
position is known as long as no other host moves an axis and the power stays on.
"""

import re
from collections.abc import Callable, Iterable, Mapping

from axistwin.drivers.arguments import ascii_text, integer, items, positive
from axistwin.drivers.axis import Fault, Status
from axistwin.drivers.core import BOTH_LIMITS, MOST_BYTES, AxisCore, Core, Line, shown
from axistwin.drivers.errors import BusyError, RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.if1_axis import I_INPUTS, MAX_DISTANCE, MAX_SPEED, START_POLLS, IF1Axis, Known, Move, Trapezoid
from axistwin.drivers.steps import Clock, Pause, Procedure, Read, Write

MOVING, AT_SPEED, DRIVE, ESTOP, LIMIT, COMMUNICATION = 1, 2, 16, 32, 64, 128
I_ESTOP, I_X_FAULT, I_Y_FAULT, I_PLUS, I_MINUS = 1, 2, 4, 16, 32
READING_ERROR = 256
"""Largest error, in steps, of a step count that is read during motion."""
CHUNK = 32
"""Number of characters sent at once; the input buffer of the controller holds 64."""
TRIES, ANSWER_S, STARTUP_S, LATE_S = 6, 0.25, 0.5, 2.0
BAUD_DETECTED = b"U\r"
"""Answer to the character `(` after a power-up."""

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


class IF1(Core):
    """An IF1 or IF2 with its three axes.

    `timeout`: longest wait for an answer; a ramp calculation takes up to 1 s.  `echo`: the controller echoes each
    character, and the core checks it before a command acts; always for 4800 and 9600 baud.  `speed_range`: 1 to 4, sets
    the highest speed.  `start_stop`: start/stop speed in steps/s.  `home_input`: number of the input with the home
    switch, 1 to 3.
    """

    line = Line(9600, stop_bits=2)

    def __init__(
        self, timeout: float = 2.0, *, echo: bool = True, speed_range: int = 1, start_stop: int = 400,
        home_input: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__(timeout)
        if speed_range not in MAX_SPEED:
            raise ValueError(f"invalid speed_range {speed_range}: expected 1 to 4")
        if home_input not in (None, *I_INPUTS):
            raise ValueError(f"invalid home_input {home_input}: expected 1, 2 or 3")
        positive("start_stop", start_stop)
        self.echo, self.speed_range, self.start_stop, self.home_input = echo, speed_range, start_stop, home_input
        self._linefeed, self._known, self._probes = False, False, 0
        self._ramp: float | None = None
        self._move: Move | None = None
        self.axes = {name: IF1Axis(self, name) for name in "XYZ"}
        self._state = Known(dict.fromkeys("XYZ", 0))

    # Synchronisation of the driver with the controller

    def synchronise(self) -> Procedure[None]:
        """Establish communication, and initialise the IF1, which needs this after each power-up."""
        yield from self._discard(0.0)
        heard = b""
        for _ in range(TRIES):
            wait = LATE_S if heard else min(ANSWER_S, self.timeout)
            if (answer := (yield from self._probe(wait))) is None:
                yield from self._adopt()
                return
            heard = answer or heard
            if not heard:
                yield Write(b"(")
                answer = heard = yield from self._receive(STARTUP_S, lambda data: data.endswith(BAUD_DETECTED))
            if answer.endswith(BAUD_DETECTED):
                yield from self._initialise()
        if heard:
            raise WrongAnswerError(
                f"the device answered {shown(heard)} to the request '(': expected the letter U, as from an IF1"
            )
        raise SilentError(f"no IF1 at this port answered the request '(' or the request 'I': {self.remedy}")

    def _probe(self, wait: float) -> Procedure[bytes | None]:
        """Return None if the controller is initialised and no answer is outstanding; otherwise what it has answered.

        Each probe asks another number of questions, so that a late answer to an earlier one is not taken for this one:
        2, 5 or 8 times E, whose answer is a letter, and 1 to 4 times I, whose answer is a number.  The rest of an
        incomplete message in the controller may spoil the first question.  Also detect whether the controller echoes
        characters, and whether a line feed follows CR in its answers.
        """
        letters, numbers = 2 + 3 * (self._probes % 3), 1 + self._probes // 3 % 4
        self._probes += 1
        yield Write(b"E\r\n" * letters + b"I\r\n" * numbers)
        answer = yield from self._receive(wait, lambda data: self._format_of(data, letters, numbers) is not None)
        if (found := self._format_of(answer, letters, numbers)) is None:
            return answer
        self.echo, self._linefeed = found
        return None

    @staticmethod
    def _format_of(answer: bytes, letters: int, numbers: int) -> tuple[bool, bool] | None:
        """Return whether the answer to a probe has an echo, and line feeds; None if it is not complete."""
        for echo, linefeed in ((True, False), (True, True), (False, False), (False, True)):
            after, before = (b"\n" if echo or linefeed else b""), (b"\n" if linefeed else b"")
            letter, number = (rb"E\r%b" % before, rb"I\r%b" % before) if echo else (b"", b"")
            letter, number = letter + rb"[\[FEC]\r" + after, number + rb" *\d+\r" + after
            found = rb"(?<!%b)(?:%b){%d,%d}(?:%b){%d}$" % (letter, letter, letters - 1, letters, number, numbers)
            if re.search(found, answer):
                return echo, linefeed
        return None

    def _receive(self, wait: float, ended: Callable[[bytes], bool]) -> Procedure[bytes]:
        """Receive bytes until `ended`, or until no first byte arrives within `wait`, or no further one in 0.25 s."""
        found = b""
        while len(found) <= MOST_BYTES and (data := (yield Read(wait))):
            found += data
            if ended(found):
                break
            wait = min(ANSWER_S, wait)
        return found

    def _initialise(self) -> Procedure[None]:
        if self._known:
            self._lose("XYZ", "the power of the IF1 was cut")
        self._known, self._move, self._ramp = False, None, None
        yield Write(b"U62\r" if self.echo else b"U61\r")
        yield Pause(0.01)

    def _adopt(self) -> Procedure[None]:
        # The status request F clears the data fault that an incomplete message has caused.
        yield from self._number("F")
        if self._known:
            yield from self._poll()
            return
        if (yield from self._motion()) & MOVING:
            self._lose("XYZ", "the IF1 was moving when the driver connected")
        else:
            yield from self._configure()
        self._state.counted = yield from self._number("N")
        self._known = True

    def _configure(self) -> Procedure[None]:
        yield from self._set_ramp(max(axis.acceleration for axis in self.axes.values()))

    def _set_ramp(self, acceleration: float) -> Procedure[None]:
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
        data = ascii_text("message", text, "X400$").encode()
        for begin in range(0, len(data), CHUNK):
            part = data[begin : begin + CHUNK]
            yield Write(part)
            if not self.echo:
                yield Pause(0.0 if begin + CHUNK >= len(data) else 0.05)
            elif (echo := (yield from self._take(len(part), text))) != part:
                yield Write(b"#\r")
                self._cancelled()
                raise WrongAnswerError(
                    f"the IF1 returned the wrong echo {shown(echo)} for the message {text}: check the line for noise"
                )
        end = b"\r\n" if self._linefeed else b"\r"
        yield Write(end)
        if self.echo and (echo := (yield from self._take(len(end), text))) != end:
            raise WrongAnswerError(
                f"the IF1 returned the wrong echo {shown(echo)} after the message {text}: check the line for noise"
            )

    def _cancelled(self) -> None:
        """Note that `#` has stopped the present move, or has deleted the message that would have begun it."""
        if self._move is not None and self._move.sure:
            self._move.stopped = True
        else:
            self._move = None

    def _number(self, request: str) -> Procedure[int]:
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
        """Read the motion status, and store its faults, which the controller clears when they are read."""
        bits = yield from self._number("K")
        self._state.latched |= bits & (DRIVE | ESTOP | LIMIT | COMMUNICATION)
        if bits & COMMUNICATION:
            self._state.communication |= yield from self._number("F")
        return bits

    # Motion

    def _poll(self) -> Procedure[bool]:
        bits = yield from self._motion()
        steps = yield from self._number("N")
        move = self._move
        if bits & MOVING:
            if move is None:
                self._lose("XYZ", "another host is moving the IF1")
            else:
                move.seen, move.sure = START_POLLS, True
                yield from self._estimate(move, steps)
            return True
        if move is not None and move.sequence and (yield from self.busy()):
            return True  # it waits for an input, or between two moves
        if (
            move is not None
            and not move.sequence
            and move.seen < START_POLLS
            and steps != move.distance
            and not bits
            and not move.stopped
        ):
            move.seen += 1  # The IF1 has not begun the commanded move yet.
            return True
        self._state.inputs = yield from self._number("I")
        self._settle(steps, bits)
        return False

    def _estimate(self, move: Move, steps: int) -> Procedure[None]:
        now: float = yield Clock()
        expected = steps if move.stopped or move.homing else move.profile.position(now - move.begun)
        near = min(max(expected, steps - READING_ERROR), steps + READING_ERROR)
        most = near if move.distance is None else move.distance
        move.made = max(move.made, min(near, most))

    def _settle(self, steps: int, bits: int) -> None:
        state, move = self._state, self._move
        if move is None:
            if steps != state.counted:
                self._lose("XYZ", "another host has moved the IF1")
        elif bits & DRIVE:
            self._lose(move.signs, "a drive fault has interrupted the move")
        elif not move.sure and steps == move.counted:
            if steps and (move.stopped or move.distance == steps):
                self._lose(
                    move.signs,
                    "the IF1 has not confirmed the move, and the step count does not show whether it was made",
                )
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
        return not move.sequence and bool(bits & (ESTOP | LIMIT)) and steps == move.counted != 0

    def begin(self, signs: dict[str, int], distance: int | None, speed: float, text: str) -> Procedure[Move]:
        """Begin a motion.  Raises RefusedError if the controller does not accept the message."""
        yield from self._ready_for(set(signs.values()))
        for name, sign in signs.items():
            target = None if distance is None else self._state.positions[name] + sign * distance
            self.axes[name]._aim(target, faults=self._faults())
        if self._state.counted:
            yield from self._reset_count(signs, speed)
        profile = Trapezoid(speed, (self._ramp or 1) * 1000.0, distance)
        self._move = move = Move(signs, distance, profile, (yield Clock()), self._state.counted)
        earlier, self._state.communication = self._state.communication, 0
        yield from self.message(text)
        move.begun, move.sure = (yield Clock()), True
        bits = yield from self._motion()
        refused, self._state.communication = self._communication_faults(), earlier | self._state.communication
        if refused and not bits & MOVING:
            self._move = None
            for name in signs:
                self.axes[name]._aim(None)
            self._state.communication = earlier
            self._state.latched &= ~COMMUNICATION
            raise RefusedError(f"the IF1 refused the message {text} ({refused[0].name}): {refused[0].remedy}")
        return move

    def _reset_count(self, signs: dict[str, int], speed: float) -> Procedure[None]:
        """Set the step count to 0 by an index of no steps.

        Otherwise a move of as many steps as the last one could not be told from a move that was not made.
        """
        words = "".join(f"{name}{'+' if sign > 0 else '-'}" for name, sign in signs.items())
        self._move = Move(signs, 0, Trapezoid(1.0, 1.0), (yield Clock()), self._state.counted, seen=START_POLLS)
        yield from self.message(f"{words}0@{speed:g}$")
        self._state.counted = yield from self._number("N")
        self._move = None

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
        if state.inputs & I_PLUS and state.inputs & I_MINUS:
            raise RefusedError(BOTH_LIMITS)
        if state.latched & LIMIT:
            fault = FAULTS[LIMIT]
            raise RefusedError(f"the IF1 does not move because of a fault ({fault.name}): {fault.remedy}")
        for direction, bit, sign in ((1, I_PLUS, "+"), (-1, I_MINUS, "-")):
            if state.inputs & bit and direction in directions:
                raise RefusedError(f"the {sign} limit is active: move in the other direction")

    def stop(self) -> Procedure[None]:
        """Decelerate all axes to a standstill, and end the running sequence, if any."""
        for axis in self.axes.values():
            axis._aim(None)
        yield from self.message("#")
        if self._move is not None:
            self._move.stopped = True

    def status_of(self, axis: "IF1Axis") -> Procedure[Status]:
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
        return axis._judged(Status(
            position, axis.setpoint, velocity, mine, mine, bool(state.inputs & I_PLUS), bool(state.inputs & I_MINUS),
            self._at_home(), self._faults(), state.lost.get(axis.name, ""),
        ))  # fmt: skip

    def _faults(self) -> tuple[Fault, ...]:
        found = [fault for bit, fault in FAULTS.items() if self._state.latched & bit]
        return (*found, *self._communication_faults())

    def _communication_faults(self) -> list[Fault]:
        return [fault for bit, fault in COMMUNICATION_FAULTS.items() if self._state.communication & bit]

    def clear_faults(self) -> Procedure[None]:
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
        """Return the position at rest.  Raises PositionLostError."""
        return round(
            Status(self._state.positions[name], 0, 0, False, lost=self._state.lost.get(name, "")).known_position()
        )

    # Functions that only the controllers IF1 and IF2 have

    def move_together(self, targets: Mapping[str, int]) -> Procedure[None]:
        """Move axes to positions at equal distances.  Raises RefusedError if the steps are not equal."""
        if not targets or not targets.keys() <= self.axes.keys():
            raise RefusedError(f"invalid axes {list(targets)}: expected X, Y or Z, e.g. {{'X': 100, 'Y': -100}}")
        targets = {name: integer("target", target, -MAX_DISTANCE, MAX_DISTANCE) for name, target in targets.items()}
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
            self.axes[name].setpoint = target
            if not distance:
                self.axes[name]._aim(target, faults=self._faults())

    def speed(self, wanted: float) -> int:
        """Return a speed rounded to whole steps/s.  Raises RefusedError if the speed is outside the speed range."""
        highest = MAX_SPEED[self.speed_range]
        if not 0.5 <= wanted <= highest:
            raise RefusedError(
                f"invalid speed {wanted:g} steps/s: expected 1 to {highest} steps/s in speed range {self.speed_range}"
            )
        return max(round(wanted), 1)

    def inputs(self) -> Procedure[dict[int, bool]]:
        """Return the inputs 1 to 3: True while current flows."""
        bits = yield from self._number("I")
        return {number: not bits & bit for number, bit in I_INPUTS.items()}

    def outputs(self, on: Iterable[int] = (), off: Iterable[int] = ()) -> Procedure[None]:
        """Switch outputs on and off.  `on`, `off`: numbers of the outputs, 1 to 5."""
        setting, resetting = (
            "".join(str(integer("output", number, 1, 5)) for number in items("outputs", numbers, "[1, 3]"))
            for numbers in (on, off)
        )
        text = (f"S{setting}" if setting else "") + (f"R{resetting}" if resetting else "")
        if text:
            yield from self.message(f"{text}$")

    def sequence(self, steps: Iterable[str]) -> Procedure[None]:
        """Store and start a sequence, e.g. ["H1", "X400@100", "S1"]; its axes then have no known position."""
        listed = [ascii_text("step", step, "X400@100") for step in items("steps", steps, '["X400@100"]')]
        if (yield from self._poll()):
            raise BusyError("the IF1 is moving: wait for the end of the motion, or stop the axes")
        moved = {name for step in listed for name in "XYZ" if name in step}
        self._lose(moved, "a sequence has moved the IF1")
        for name in moved:
            self.axes[name]._aim(None)
        yield from self.message(":" + ":".join(listed) + ":$")
        signs = dict.fromkeys(moved, 0)  # the driver does not calculate the motion
        self._move = Move(signs, None, Trapezoid(1.0, 1.0), (yield Clock()), self._state.counted, sequence=True)

    def busy(self) -> Procedure[bool]:
        """Return True while the controller executes a move, a wait or an output pulse."""
        yield from self.message("E")
        answer = (yield from self._until(b"\r", "E")).strip()
        if self._linefeed:
            yield from self._until(b"\n", "E")
        return answer == b"E"
