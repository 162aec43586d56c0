"""One board: it is configured, receives step commands, and reports inputs; without input or output of its own.

CONNECTING ──▶ READY ◀──▶ axes of a controller stopped (limit, late, a human's stop)
    │            │
    └──▶ FAILED ◀┘        the firmware has stopped, or does not answer
"""

from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any

from axistwin.errors import AxistwinError, LinkError
from axistwin.motion.step_queue import Steps, plan
from axistwin.standin.channel import RECEIVE_WINDOW, Channel
from axistwin.standin.clock_fit import ClockFit
from axistwin.standin.dictionary import Dictionary
from axistwin.standin.events import Event, Failed, InputChanged, Ready, Stopped
from axistwin.standin.wiring import AxisPins, InputPin, Objects, Wiring, objects

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TOLERANCE_S = 0.5e-6
"""Largest distance of a pulse from its time."""
LEAD_S = 0.01
"""Step commands must leave this long before their first pulse."""
SOON_S = 0.05
"""Time after which a command has certainly reached a board that answers."""
MOST_SILENT_S, MOST_SILENT_AT_START_S = 1.0, 5.0
"""A board that acknowledges nothing for this long has failed.  A board that has just been reset takes longer."""
WORST_FIT_S = 50e-6
"""Largest error of the clock fit with which motion may start."""
CLOCK_S, CLOCK_AT_START_S = 1.0, 0.02
"""Intervals at which the board's clock is read."""
ANSWER_S, MOST_REQUESTS = 0.25, 24
"""Time after which a request is repeated, and number of requests."""
REPORT_S = 0.1
"""Interval at which the board repeats the state of its triggers, as responses may be lost."""
IDENTIFY_BYTES = 40
SPARE_MOVES = 6
"""Entries of the board's queue that stay free."""
LIMIT_REASON, HOST_REASON = 1, 2


class State(Enum):
    """State of a board."""

    CONNECTING = "connecting"
    READY = "ready"
    FAILED = "failed"


@dataclass
class _Motor:
    """An axis on the board.  `last`: tick of its last planned pulse; `position`: net pulses planned."""

    pins: AxisPins
    oid: int
    last: int | None = None
    direction: int = 0
    position: int = 0
    origin: int | None = None
    """The board's count at position 0."""
    waiting: deque[tuple[int | None, int, int, Steps]] = field(default_factory=deque)
    """Planned commands: tick from which the first one counts (None: from the last pulse), first tick, direction."""


@dataclass
class _Request:
    """A request: `procedure` goes on with the response of this name and object number."""

    procedure: "Procedure"
    name: str
    oid: int | None
    content: bytes
    left: int
    again_at_s: float


Procedure = Generator[tuple[str, int | None, bytes], dict[str, Any], None]


class Board:
    """A board with its wiring.  Times are those of the host in seconds; `journal` receives one line per act."""

    def __init__(
        self,
        wiring: Wiring,
        horizon_s: float = 0.1,
        journal: Callable[[str], None] = lambda line: None,
        positions: Mapping[str, int] | None = None,
    ) -> None:
        """`positions`: net pulses at the start, by axis; 0 if left out."""
        self.wiring, self.horizon_s, self._note = wiring, horizon_s, journal
        self._at_start = dict(positions or {})
        self.dictionary = Dictionary()
        self.channel = Channel()
        self.state = State.CONNECTING
        self.events: deque[Event] = deque()
        """What happened, in order; the user of the board empties it."""
        self.clock = ClockFit(1.0)
        self.moves = 0
        """Entries of the board's queue."""
        self.stopped: set[str] = set()
        """Controllers whose axes are stopped: their pulses are dropped."""
        self._objects = Objects()
        self._motors: dict[str, _Motor] = {}
        self._levels: dict[str, bool] = {}
        self._in_queue: list[float] = []
        self._requests: list[_Request] = []
        self._now_s = 0.0
        self._clock_sent_s: float | None = None
        self._next_clock_s = self._next_feed_s = 0.0
        self._stopping: set[str] = set()
        self._handled: set[str] = set()
        self._begin(self._start())

    # The wire

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the board."""
        self._now_s = now_s
        for content in self.channel.receive(data, now_s):
            name, values = self.dictionary.decode(content)
            if name:
                self._received(name, values)

    def due(self, now_s: float) -> bytes:
        """Return the bytes to send to the board now.  Call at least every 5 ms."""
        self._now_s = now_s
        if self.state is State.FAILED:
            return b""
        most_s = MOST_SILENT_S if self.dictionary.constants else MOST_SILENT_AT_START_S
        if self.channel.silent_s(now_s) > most_s:
            self.fail("the board does not answer: check its cable, its power and its firmware, then go on")
            return b""
        self._repeat_requests()
        if self._objects.steppers:
            self._read_clock()
        if self.state is State.READY:
            self._feed()
            self._pump()
        return self.channel.due(now_s)

    def _send(self, name: str, **values: int) -> None:
        self.channel.send(self.dictionary.encode(name, **values))

    def _received(self, name: str, values: dict[str, Any]) -> None:
        match name:
            case "clock" if self._clock_sent_s is not None:
                self.clock.add(self._clock_sent_s, self._now_s, values["clock"])
                self._clock_sent_s = None
            case "shutdown" | "is_shutdown" if self.state is State.READY:
                self.fail(f"the board has stopped: {values['static_string_id']}")
            case "trsync_state" if self.state is State.READY and not values["can_trigger"]:
                self._triggered(values["oid"], values["trigger_reason"])
        for request in [each for each in self._requests if each.name == name]:
            if request.oid is None or request.oid == values.get("oid"):
                self._requests.remove(request)
                self._advance(request.procedure, values)

    def fail(self, reason: str) -> None:
        """Give the board up until `restart`."""
        if self.state is not State.FAILED:
            self.state = State.FAILED
            self._requests.clear()
            self.channel.drop_waiting()
            self._drop_pulses(self.wiring.groups)
            self._note(f"failed {reason}")
            self.events.append(Failed(reason))

    # Procedures: generators that yield requests

    def _begin(self, procedure: Procedure) -> None:
        self._advance(procedure, None)

    def _advance(self, procedure: Procedure, values: dict[str, Any] | None) -> None:
        try:
            name, oid, content = next(procedure) if values is None else procedure.send(values)
        except StopIteration:
            return
        except AxistwinError as error:
            self.fail(str(error))
            return
        if content:
            self.channel.send(content)
        self._requests.append(_Request(procedure, name, oid, content, MOST_REQUESTS, self._now_s + ANSWER_S))

    def _repeat_requests(self) -> None:
        """Repeat requests whose response may have been lost."""
        for request in self._requests:
            if request.content and self._now_s >= request.again_at_s:
                request.left -= 1
                request.again_at_s = self._now_s + ANSWER_S
                if not request.left:
                    self.fail(f"the board does not answer ({request.name}): check its firmware, then go on")
                    return
                self.channel.send(request.content)

    def _ask(self, name: str, answer: str, **values: int) -> Generator[Any, dict[str, Any], dict[str, Any]]:
        found: dict[str, Any] = yield answer, values.get("oid"), self.dictionary.encode(name, **values)
        return found

    # Start

    def restart(self, now_s: float) -> None:
        """Go on after a failure, at a human's word."""
        self._now_s, self.state = now_s, State.CONNECTING
        self.channel, self.dictionary, self._objects = Channel(), Dictionary(), Objects()
        self.stopped.clear()
        self._stopping.clear()
        self._handled.clear()
        self._in_queue.clear()
        self._begin(self._start())

    def _start(self) -> Procedure:
        yield from self._identify()
        self.wiring.check_pins(self.dictionary)
        made = objects(self.wiring, self.dictionary)
        yield from self._configure(made)
        self._objects = made
        self.clock = ClockFit(self.dictionary.clock_hz)
        while not self.clock.ready:
            yield "clock", None, b""
        if self.clock.error_s > WORST_FIT_S:
            raise LinkError(
                f"the board's clock cannot be followed: error {self.clock.error_s * 1e6:.0f} µs: expected at most 50: "
                "use another USB port or cable"
            )
        yield from self._read_positions(self.wiring.groups)
        for given in self.wiring.inputs:
            state = yield from self._ask("endstop_query_state", "endstop_state", oid=made.endstops[given.to])
            self._levels[given.to] = bool(state["pin_value"]) is not given.pin.inverted
        self._check_switches()
        self.state = State.READY
        for group in self.wiring.groups:
            self._arm(group)
        for given in self.wiring.inputs:
            if given.stops is None:
                self._watch(given)
        self._note(f"ready {self.dictionary.version}")
        positions = {axis: motor.position for axis, motor in self._motors.items()}
        self.events.append(Ready(positions, dict(self._levels)))

    def _identify(self) -> Procedure:
        data = bytearray()
        while True:
            answer = yield from self._ask("identify", "identify_response", offset=len(data), count=IDENTIFY_BYTES)
            if answer["offset"] == len(data):
                data += answer["data"]
                if not answer["data"]:
                    break
        self.dictionary = Dictionary.unpack(bytes(data))
        self.channel.window = int(self.dictionary.constants.get("RECEIVE_WINDOW", RECEIVE_WINDOW))

    def _configure(self, made: Objects) -> Procedure:
        config = yield from self._ask("get_config", "config")
        was_configured = config["is_config"]
        if config["is_config"] and config["crc"] & 0xFFFF_FFFF != made.crc:
            raise LinkError("the board is configured for another scene: press its reset button, then go on")
        if self._motors and not was_configured:
            raise LinkError("the board was reset, so its position is unknown: begin again with --unhomed, then home")
        if config["is_shutdown"]:
            self._send("clear_shutdown")
        if not config["is_config"]:
            for command in made.commands:
                self.channel.send(command)
        config = yield from self._ask("get_config", "config")
        if not config["is_config"] or config["is_shutdown"]:
            raise LinkError("the board has refused its configuration: press its reset button, then go on")
        self.moves = config["move_count"]
        needed = SPARE_MOVES + len(self.wiring.outputs) + 12 * len(self.wiring.axes)
        if self.moves < needed:
            raise LinkError(f"the board's queue has {self.moves} entries: expected at least {needed}: use fewer axes")
        if not self._motors:
            self._motors = {axis.axis: _Motor(axis, made.steppers[axis.axis]) for axis in self.wiring.axes}

    def _read_positions(self, groups: tuple[str, ...]) -> Procedure:
        for motor in self._in(groups):
            answer = yield from self._ask("stepper_get_position", "stepper_position", oid=motor.oid)
            counted = -answer["pos"] if motor.pins.direction.inverted else answer["pos"]
            if motor.origin is None:
                motor.origin = counted - self._at_start.get(motor.pins.axis, 0)
            motor.position, motor.last, motor.direction = counted - motor.origin, None, 0
            self._note(f"position {motor.pins.axis} {motor.position}")

    def _check_switches(self) -> None:
        """Raise LinkError if an emergency stop is open, and note which limits are."""
        for given in self.wiring.inputs:
            if given.stops == 0 and self._levels[given.to] is given.stops_at:
                raise LinkError(f"{given.to} is open: close it, then go on")

    # Stops by the board

    def _in(self, groups: tuple[str, ...]) -> Iterator[_Motor]:
        return (motor for motor in self._motors.values() if motor.pins.controller in groups)

    def _stop_inputs(self, group: str) -> Iterator[InputPin]:
        return (given for given in self.wiring.inputs if given.stops is not None and given.controller == group)

    def _arm(self, group: str) -> None:
        """Let the stop inputs of a controller stop its axes in the board, except those that are open already."""
        trsync = self._objects.groups[group]
        self._send("trsync_start", oid=trsync, report_clock=self._soon(), report_ticks=self._ticks(REPORT_S),
                   expire_reason=0)  # fmt: skip
        for motor in self._in((group,)):
            self._send("stepper_stop_on_trigger", oid=motor.oid, trsync_oid=trsync)
        for number, given in enumerate(self.wiring.inputs):
            if given.stops is not None and given.controller == group:
                if self._levels[given.to] is given.stops_at:
                    self._watch(given)
                else:
                    self._home(given, given.stops_at, trsync, HOST_REASON + 1 + number)
        self._handled.discard(group)

    def _watch(self, given: InputPin) -> None:
        """Let the board report the next change of an input."""
        watch = self._objects.watches[given.to]
        self._send("trsync_start", oid=watch, report_clock=self._soon(), report_ticks=self._ticks(REPORT_S),
                   expire_reason=0)  # fmt: skip
        self._handled.discard(given.to)
        self._home(given, not self._levels[given.to], watch, LIMIT_REASON)

    def _home(self, given: InputPin, level: bool, trsync: int, reason: int) -> None:
        rest_s = self.wiring.sample_s if given.stops is None else self.wiring.stop_sample_s
        self._send("endstop_home", oid=self._objects.endstops[given.to], clock=self._soon(), sample_ticks=0,
                   sample_count=1, rest_ticks=self._ticks(rest_s), pin_value=int(level is not given.pin.inverted),
                   trsync_oid=trsync, trigger_reason=reason)  # fmt: skip

    def _soon(self) -> int:
        """Return a board time that has come when a command with it arrives, or comes soon after."""
        return int(self.clock.ticks(self._now_s + SOON_S)) & 0xFFFF_FFFF

    def _ticks(self, seconds: float) -> int:
        return round(seconds * self.dictionary.clock_hz)

    def _triggered(self, oid: int, reason: int) -> None:
        """Handle the report of a trigger, once."""
        groups = {number: group for group, number in self._objects.groups.items()}
        if oid in groups:
            group = groups[oid]
            if reason > HOST_REASON and group not in self._handled and group not in self._stopping:
                self._handled.add(group)
                given = self.wiring.inputs[reason - HOST_REASON - 1]
                self._drop_pulses((group,))
                self._begin(self._stopped_by(given, group))
            return
        given = next(each for each in self.wiring.inputs if self._objects.watches[each.to] == oid)
        if reason == LIMIT_REASON and given.to not in self._handled:
            self._handled.add(given.to)
            self._begin(self._changed(given))

    def _trigger_s(self, given: InputPin) -> Generator[Any, dict[str, Any], float]:
        """Return the time at which an input was sampled at its new level."""
        state = yield from self._ask("endstop_query_state", "endstop_state", oid=self._objects.endstops[given.to])
        rest_s = self.wiring.sample_s if given.stops is None else self.wiring.stop_sample_s
        return self.clock.time_s(self.clock.unwrapped(state["next_clock"]) - self._ticks(rest_s))

    def _stopped_by(self, given: InputPin, group: str) -> Procedure:
        at_s = yield from self._trigger_s(given)
        yield from self._read_positions((group,))
        self._levels[given.to] = given.stops_at
        self._note(f"stopped by {given.to}")
        self.events.append(InputChanged(given.to, given.stops_at, at_s))
        self.events.append(Stopped(f"{given.to} stopped the motion", self._positions(group), given.to))

    def _changed(self, given: InputPin) -> Procedure:
        at_s = yield from self._trigger_s(given)
        level = self._levels[given.to] = not self._levels[given.to]
        self._note(f"input {given.to} {int(level)}")
        self.events.append(InputChanged(given.to, level, at_s))
        if given.stops is None:
            self._watch(given)
        elif given.controller not in self.stopped:
            trsync = self._objects.groups[given.controller]
            number = HOST_REASON + 1 + self.wiring.inputs.index(given)
            self._home(given, given.stops_at, trsync, number)

    def stop(self, reason: str, groups: tuple[str, ...] = ()) -> None:
        """Stop axes at once: those of these controllers, or all."""
        stopping = tuple(group for group in groups or self.wiring.groups if group not in self._stopping)
        if self.state is State.READY and stopping:
            self._stopping |= set(stopping)
            self._drop_pulses(stopping)
            self._note(f"stop {reason}")
            self._begin(self._stop_now(reason, stopping))

    def _stop_now(self, reason: str, groups: tuple[str, ...]) -> Procedure:
        for group in groups:
            yield from self._ask("trsync_trigger", "trsync_state", oid=self._objects.groups[group], reason=HOST_REASON)
        yield from self._read_positions(groups)
        positions = {axis: at for group in groups for axis, at in self._positions(group).items()}
        self.events.append(Stopped(reason, positions))

    def _positions(self, group: str) -> dict[str, int]:
        return {motor.pins.axis: motor.position for motor in self._in((group,))}

    def resume(self, group: str) -> None:
        """Accept pulses of a controller again; its stop inputs stop its axes as before."""
        if self.state is State.READY and group in self.stopped:
            self.stopped.discard(group)
            self._stopping.discard(group)
            self._arm(group)

    # Pulses

    def _drop_pulses(self, groups: tuple[str, ...]) -> None:
        """Drop the pulses that have not left, and all further ones until `resume`."""
        self.stopped |= set(groups)
        for motor in self._in(groups):
            motor.waiting.clear()

    def queue(self, axis: str, direction: int, times_s: "NDArray[np.float64]") -> None:
        """Make pulses at these times plus the horizon; direction +1 or -1.  The ceilings are checked first."""
        motor = self._motors.get(axis)
        if self.state is not State.READY or not len(times_s) or motor is None or motor.pins.controller in self.stopped:
            return
        wanted = self.clock.ticks(0.0) + (times_s + self.horizon_s) * self.clock.hz
        if refused := self._refusal(motor, direction, wanted):
            self.stop(refused, (motor.pins.controller,))
            return
        base = motor.last
        if base is None or (not motor.waiting and base < self.clock.ticks(self._now_s) - self._ticks(2 * LEAD_S)):
            base = int(wanted[0]) - self._ticks(LEAD_S / 2)
            motor.last = None
        start, last = base if motor.last is None else None, base
        try:
            for steps in plan(wanted, base, TOLERANCE_S * self.clock.hz):
                motor.waiting.append((start, last + steps.interval, direction, steps))
                start, last = None, last + steps.ticks
        except ValueError as error:
            self.stop(f"{axis}: {error}", (motor.pins.controller,))
            return
        motor.last = last
        motor.position += direction * len(wanted)

    def _refusal(self, motor: _Motor, direction: int, wanted: "NDArray[np.float64]") -> str:
        """Return the ceiling that these pulses would break; "": none."""
        import numpy as np

        pins = motor.pins
        gaps = np.diff(wanted, prepend=motor.last if motor.last is not None else -np.inf)
        rate = self.clock.hz / max(float(gaps.min()), 1e-9)
        if pins.max_rate is not None and rate > pins.max_rate * 1.001:
            return f"{pins.axis}: {rate:.0f} pulses/s is above max_rate {pins.max_rate:g}"
        end = motor.position + direction * len(wanted)
        if pins.travel is not None and not pins.travel[0] <= end <= pins.travel[1]:
            return f"{pins.axis}: position {end} is beyond travel {list(pins.travel)}"
        for given in self._stop_inputs(pins.controller):
            if self._levels[given.to] is given.stops_at and given.stops in (0, direction):
                return f"{pins.axis}: {given.to} is open: no motion in this direction"
        return ""

    def _pump(self) -> None:
        """Send the earliest commands for which the board has room."""
        now = self.clock.ticks(self._now_s)
        while self._in_queue and self._in_queue[0] < now:
            heappop(self._in_queue)
        room = self.moves - SPARE_MOVES - len(self.wiring.outputs)
        while first := min((motor for motor in self._motors.values() if motor.waiting), key=_due, default=None):
            late_s = (now - _due(first)) / self.clock.hz + LEAD_S
            if late_s > 0:
                self.stop(f"late by {late_s * 1e3:.0f} ms, with a horizon of {self.horizon_s * 1e3:.0f} ms")
                return
            if len(self._in_queue) >= room:
                return
            self._send_steps(first, *first.waiting.popleft())

    def _send_steps(self, motor: _Motor, base: int | None, first: int, direction: int, steps: Steps) -> None:
        if base is not None:
            self._send("reset_step_clock", oid=motor.oid, clock=base & 0xFFFF_FFFF)
        if direction != motor.direction:
            positive = int((direction > 0) is not motor.pins.direction.inverted)
            self._send("set_next_step_dir", oid=motor.oid, dir=positive)
            motor.direction = direction
        self._send("queue_step", oid=motor.oid, interval=steps.interval, count=steps.count, add=steps.add)
        heappush(self._in_queue, first)
        self._note(f"pulses {motor.pins.axis} {direction:+d} {first} {steps.interval} {steps.count} {steps.add}")

    # Outputs, watchdog and clock

    def set_output(self, source: str, level: bool, at_s: float) -> None:
        """Set an output, one horizon after this time."""
        if self.state is State.READY:
            output = next(each for each in self.wiring.outputs if each.source == source)
            clock = int(self.clock.ticks(max(at_s + self.horizon_s, self._now_s + 2 * LEAD_S)))
            on = int(level is not output.pin.inverted)
            self._send("queue_digital_out", oid=self._objects.outputs[source], clock=clock & 0xFFFF_FFFF, on_ticks=on)

    def _feed(self) -> None:
        """Enable the drives for the time of the watchdog; the board switches them off unless this is repeated."""
        if self._now_s >= self._next_feed_s:
            self._next_feed_s = self._now_s + self.wiring.watchdog_s / 5
            for pin, oid in self._objects.enables.items():
                self._send("update_digital_out", oid=oid, value=int(not pin.inverted))

    def _read_clock(self) -> None:
        if self._now_s >= self._next_clock_s:
            self._next_clock_s = self._now_s + (CLOCK_S if self.clock.ready else CLOCK_AT_START_S)
            self._clock_sent_s = None
            self.channel.send(self.dictionary.encode("get_clock"), self._clock_has_left)

    def _clock_has_left(self, at_s: float) -> None:
        self._clock_sent_s = at_s

    def shut_down(self) -> None:
        """Stop everything and switch the drives off, at the end of a run."""
        if self.dictionary.constants:
            self._send("emergency_stop")


def _due(motor: _Motor) -> int:
    return motor.waiting[0][1]
