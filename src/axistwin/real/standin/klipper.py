"""A motion board with Klipper's firmware: its configuration, its step commands, its inputs; without input or output."""

from collections.abc import Callable, Generator, Mapping
from typing import Any

from axistwin.core.errors import LinkError
from axistwin.core.lazy import NDArray, np
from axistwin.real.standin.board import Board, State
from axistwin.real.standin.channel import RECEIVE_WINDOW
from axistwin.real.standin.clock_fit import WORST_S
from axistwin.real.standin.connection import Connection, Procedure
from axistwin.real.standin.dictionary import Dictionary
from axistwin.real.standin.events import InputChanged, Ready, Stopped
from axistwin.real.standin.step_stream import LEAD_S, Motor, StepStream
from axistwin.real.standin.timetable import Timetable
from axistwin.real.standin.wiring import DrivenAxis, InputPin, Objects, Wiring, objects

IDENTIFY_BYTES = 40
MOST_FITS, FIT_SAMPLES = 4, 100  # Attempts to fit a line to the board's clock, and samples of each: 2 s.
SPARE_MOVES = 6  # Number of entries of the board's queue that are never used.
MOVES_PER_AXIS = 12  # Number of entries of the board's queue that each axis needs.
LIMIT_REASON, HOST_REASON = 1, 2  # Why a board's trigger reports: a changed input, or a stop by the host.


class KlipperBoard(Board):
    """A board with Klipper's firmware and its wiring."""

    wiring: Wiring

    def __init__(
        self, wiring: Wiring, horizon_s: float = 0.1, journal: Callable[[str], None] = lambda line: None,
        positions: Mapping[str, int] | None = None,
    ) -> None:  # fmt: skip
        """Begin to connect to the board.  `positions`: position of each axis at the start, in pulses; default 0."""
        super().__init__(wiring, horizon_s, journal)
        self._at_start = dict(positions or {})
        self.connection = Connection(self.fail)
        self._stream = StepStream(self.connection, journal)
        self._objects, self._timetable = Objects(), Timetable(wiring, 1.0)
        self._next_feed_s = 0.0
        self._handled: set[str] = set()  # Controllers and inputs whose latest trigger has been handled.
        self.connection.begin(self._start())

    def receive(self, data: bytes, now_s: float) -> None:
        self.connection.now_s = now_s
        for name, values in self.connection.receive(data):
            if self.state is not State.READY:
                continue
            if name in ("shutdown", "is_shutdown"):
                self.fail(f"the board has stopped: {values['static_string_id']}")
            elif name == "trsync_state" and not values["can_trigger"]:
                self._triggered(values["oid"], values["trigger_reason"])

    def due(self, now_s: float) -> bytes:
        """Return the bytes that must be sent to the board now.  Must be called at least every 5 ms."""
        self.connection.now_s = now_s
        if self.state is State.FAILED:
            return b""
        if self.connection.silent:
            self.fail("the board does not answer: check its cable, its power and its firmware, then try again")
            return b""
        self.connection.repeat_requests()
        if self._objects.steppers:
            self.connection.read_clock()
        if self.state is State.READY:
            self._feed()
            if late_s := self._stream.send_due():
                self.stop(f"late by {late_s * 1e3:.0f} ms, with a horizon of {self.horizon_s * 1e3:.0f} ms")
        return self.connection.channel.due(now_s)

    def fail(self, reason: str, *, gone: bool = False) -> None:
        if self.state is not State.FAILED or gone:
            self.connection.drop()
        super().fail(reason, gone=gone)

    # Start

    def restart(self, now_s: float) -> None:
        self.state, self._objects = State.CONNECTING, Objects()
        self.connection.restart(now_s)
        self.stopped.clear()
        self._stopping.clear()
        self._handled.clear()
        self._stream.forget_queue()
        self.connection.begin(self._start())

    def _start(self) -> Procedure:
        connection = self.connection
        yield from self._identify()
        self.wiring.check_pins(connection.dictionary)
        made = objects(self.wiring, connection.dictionary)
        self._timetable = Timetable(self.wiring, connection.dictionary.clock_hz)
        yield from self._configure(made)
        self._objects = made
        yield from self._fit_clock()
        yield from self._read_positions(self.wiring.groups)
        for given in self.wiring.inputs:
            state = yield from connection.ask("endstop_query_state", "endstop_state", oid=made.endstops[given.to])
            self._levels[given.to] = bool(state["pin_value"]) is not given.pin.inverted
        if open_stop := self._open_stop:
            raise LinkError(open_stop)
        self.state = State.READY
        for group in self.wiring.groups:
            self._arm(group)
        for given in self.wiring.inputs:
            if given.stops is None:
                self._report_change(given)
        positions = {axis: motor.position for axis, motor in self._stream.motors.items()}
        self.events.append(Ready(positions, dict(self._levels)))
        self._note(f"ready {connection.dictionary.version}")

    def _identify(self) -> Procedure:
        connection, data = self.connection, bytearray()
        while True:
            answer = yield from connection.ask("identify", "identify_response", offset=len(data), count=IDENTIFY_BYTES)
            if answer["offset"] == len(data):
                data += answer["data"]
                if not answer["data"]:
                    break
        connection.dictionary = Dictionary.unpack(bytes(data))
        connection.channel.window = int(connection.dictionary.constants.get("RECEIVE_WINDOW", RECEIVE_WINDOW))

    def _configure(self, made: Objects) -> Procedure:
        motors = self._stream.motors
        config = yield from self.connection.ask("get_config", "config")
        if config["is_config"] and config["crc"] & 0xFFFF_FFFF != made.crc:
            raise LinkError("the board is configured for another scene: press its reset button, then try again")
        if motors and not config["is_config"]:
            raise LinkError(
                "the board was reset, so its positions are unknown: start again with --unhomed, then home the axes"
            )
        if config["is_shutdown"]:
            self.connection.send("clear_shutdown")
        if not config["is_config"]:
            for command in made.commands:
                self.connection.channel.send(command)
        config = yield from self.connection.ask("get_config", "config")
        if not config["is_config"] or config["is_shutdown"]:
            raise LinkError("the board has refused its configuration: press its reset button, then try again")
        moves, outputs = config["move_count"], len(self.wiring.outputs)
        needed = SPARE_MOVES + outputs + MOVES_PER_AXIS * len(self.wiring.axes)
        if moves < needed:
            raise LinkError(
                f"the board can queue only {moves} moves: expected at least {needed} "
                f"({MOVES_PER_AXIS} for each axis, 1 for each output, {SPARE_MOVES} in reserve)"
            )
        self._stream.room = moves - SPARE_MOVES - outputs
        if not motors:
            motors.update({axis.axis: Motor(axis, made.steppers[axis.axis]) for axis in self.wiring.axes})

    def _fit_clock(self) -> Procedure:
        connection = self.connection
        for _ in range(MOST_FITS):
            connection.forget_clock()
            for _ in range(FIT_SAMPLES):
                yield "clock", None, b""
                if connection.clock.good:
                    connection.clock.steady = True
                    return
        error_us, most_us = connection.clock.error_s * 1e6, WORST_S * 1e6
        raise LinkError(
            f"the host cannot synchronise with the board's clock: the error is {error_us:.0f} µs, "
            f"expected at most {most_us:.0f} µs; USB delays cause such errors, so use another USB port or cable"
        )

    def _read_positions(self, groups: tuple[str, ...]) -> Procedure:
        for motor in self._stream.of(groups):
            answer = yield from self.connection.ask("stepper_get_position", "stepper_position", oid=motor.oid)
            counted = -answer["pos"] if motor.pins.direction.inverted else answer["pos"]
            if motor.origin is None:
                motor.origin = counted - self._at_start.get(motor.pins.axis, 0)
            motor.position, motor.last, motor.direction = counted - motor.origin, None, 0
            self._note(f"position {motor.pins.axis} {motor.position}")

    # Inputs of the board

    def _arm(self, group: str) -> None:
        """Configure the board to stop a controller's axes at its stop inputs; open ones are only reported."""
        trsync = self._objects.groups[group]
        self._start_trigger(trsync)
        for motor in self._stream.of((group,)):
            self.connection.send("stepper_stop_on_trigger", oid=motor.oid, trsync_oid=trsync)
        for given in self.wiring.inputs:
            if given.stops is not None and given.controller == group:
                if self._levels[given.to] is given.stops_at:
                    self._report_change(given)
                else:
                    self._stop_at_change(given)
        self._handled.discard(group)

    def _start_trigger(self, oid: int) -> None:
        clock = self._timetable.reporting(oid, self.connection.soon()) & 0xFFFF_FFFF
        self.connection.send("trsync_start", oid=oid, report_clock=clock, report_ticks=self._timetable.report,
                             expire_reason=0)  # fmt: skip

    def _report_change(self, given: InputPin) -> None:
        watch = self._objects.watches[given.to]
        self._start_trigger(watch)
        self._handled.discard(given.to)
        self._home(given, not self._levels[given.to], watch, LIMIT_REASON)

    def _stop_at_change(self, given: InputPin) -> None:
        reason = HOST_REASON + 1 + self.wiring.inputs.index(given)
        self._home(given, given.stops_at, self._objects.groups[given.controller], reason)

    def _home(self, given: InputPin, level: bool, trsync: int, reason: int) -> None:
        connection, timetable = self.connection, self._timetable
        connection.send("endstop_home", oid=self._objects.endstops[given.to], sample_ticks=0, sample_count=1,
                        clock=timetable.reading(given, connection.soon()) & 0xFFFF_FFFF,
                        rest_ticks=timetable.interval(given), pin_value=int(level is not given.pin.inverted),
                        trsync_oid=trsync, trigger_reason=reason)  # fmt: skip

    def _triggered(self, oid: int, reason: int) -> None:
        """Handle the board's report that an input has changed, and ignore repetitions of the report."""
        groups = {number: group for group, number in self._objects.groups.items()}
        if oid in groups:
            group = groups[oid]
            if reason > HOST_REASON and group not in self._handled and group not in self._stopping:
                self._handled.add(group)
                given = self.wiring.inputs[reason - HOST_REASON - 1]
                self._drop_pulses((group,))
                self.connection.begin(self._stopped_by(given, group))
            return
        given = next(each for each in self.wiring.inputs if self._objects.watches[each.to] == oid)
        if reason == LIMIT_REASON and given.to not in self._handled:
            self._handled.add(given.to)
            self.connection.begin(self._changed(given))

    def _trigger_s(self, given: InputPin) -> Generator[Any, dict[str, Any], float]:
        connection, oid = self.connection, self._objects.endstops[given.to]
        state = yield from connection.ask("endstop_query_state", "endstop_state", oid=oid)
        next_sample = connection.clock.unwrapped(state["next_clock"])
        return connection.clock.time_s(next_sample - self._timetable.interval(given))

    def _stopped_by(self, given: InputPin, group: str) -> Procedure:
        at_s = yield from self._trigger_s(given)
        yield from self._read_positions((group,))
        self._levels[given.to] = given.stops_at
        self.events.append(InputChanged(given.to, given.stops_at, at_s))
        self.events.append(Stopped(f"{given.to} stopped the motion", self._positions((group,)), given.to))
        self._note(f"stopped by {given.to}")

    def _changed(self, given: InputPin) -> Procedure:
        at_s = yield from self._trigger_s(given)
        level = self._levels[given.to] = not self._levels[given.to]
        self.events.append(InputChanged(given.to, level, at_s))
        if given.stops is None:
            self._report_change(given)
        elif given.controller not in self.stopped:
            self._stop_at_change(given)
        self._note(f"input {given.to} {int(level)}")

    # Stopping and resuming the axes of a controller

    def _stop(self, reason: str, groups: tuple[str, ...]) -> None:
        self.connection.begin(self._stop_now(reason, groups))

    def _stop_now(self, reason: str, groups: tuple[str, ...]) -> Procedure:
        for group in groups:
            oid = self._objects.groups[group]
            yield from self.connection.ask("trsync_trigger", "trsync_state", oid=oid, reason=HOST_REASON)
        yield from self._read_positions(groups)
        self.events.append(Stopped(reason, self._positions(groups)))

    def _positions(self, groups: tuple[str, ...]) -> dict[str, int]:
        return {motor.pins.axis: motor.position for motor in self._stream.of(groups)}

    def _resume(self, group: str) -> None:
        self._stopping.pop(group, None)
        self._arm(group)

    # Pulses and outputs

    def _add(self, driven: DrivenAxis, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float) -> str:
        motor, clock = self._stream.motors[driven.axis], self.connection.clock
        wanted = clock.ticks(0.0) + (times_s + self.horizon_s) * clock.hz
        refused = motor.refusal(direction, wanted, clock.hz) or self._blocked(driven, direction)
        if not refused:
            try:
                self._stream.add(motor, direction, wanted, tolerance_s)
            except ValueError as error:
                refused = f"{driven.axis}: {error}"
        return refused

    def _drop_pulses(self, groups: tuple[str, ...]) -> None:
        super()._drop_pulses(groups)
        for motor in self._stream.of(groups):
            motor.waiting.clear()

    def _switch(self, source: str, level: bool, at_s: float) -> None:
        connection = self.connection
        output = next(each for each in self.wiring.outputs if each.source == source)
        clock = int(connection.clock.ticks(max(at_s + self.horizon_s, connection.now_s + 2 * LEAD_S)))
        on = int(level is not output.pin.inverted)
        oid = self._objects.outputs[source]
        connection.send("queue_digital_out", oid=oid, clock=clock & 0xFFFF_FFFF, on_ticks=on)

    def _feed(self) -> None:
        """Send the enable command regularly, so that the board's watchdog does not switch off the drives."""
        if self.connection.now_s >= self._next_feed_s:
            self._next_feed_s = self.connection.now_s + self.wiring.watchdog_s / 5
            for pin, oid in self._objects.enables.items():
                self.connection.send("update_digital_out", oid=oid, value=int(not pin.inverted))

    def shut_down(self) -> None:
        if self.connection.dictionary.constants:
            self.connection.send("emergency_stop")
