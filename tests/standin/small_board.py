"""A simulated board with the protocol of Klipper's firmware, in virtual time; it records its pulses.

The protocol is described in `docs/Protocol.md` and `docs/MCU_Commands.md` of the firmware.
"""

import heapq
import json
import zlib
from itertools import count

from axistwin.real.standin import frames
from axistwin.real.standin.dictionary import Dictionary

COMMANDS = [
    "get_config", "allocate_oids count=%c", "finalize_config crc=%u", "get_clock", "get_uptime", "emergency_stop",
    "clear_shutdown", "config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u",
    "queue_step oid=%c interval=%u count=%hu add=%hi", "set_next_step_dir oid=%c dir=%c",
    "reset_step_clock oid=%c clock=%u", "stepper_get_position oid=%c",
    "stepper_stop_on_trigger oid=%c trsync_oid=%c", "config_endstop oid=%c pin=%c pull_up=%c",
    ("endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c trsync_oid=%c"
     " trigger_reason=%c"), "endstop_query_state oid=%c", "config_trsync oid=%c",
    "trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c",
    "trsync_set_timeout oid=%c clock=%u", "trsync_trigger oid=%c reason=%c",
    "config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u",
    "queue_digital_out oid=%c clock=%u on_ticks=%u", "update_digital_out oid=%c value=%c",
]  # fmt: skip
RESPONSES = [
    "config is_config=%c crc=%u is_shutdown=%c move_count=%hu", "clock clock=%u", "stepper_position oid=%c pos=%i",
    "trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u",
    "endstop_state oid=%c homing=%c next_clock=%u pin_value=%c", "shutdown clock=%u static_string_id=%hu",
    "is_shutdown static_string_id=%hu",
]  # fmt: skip
REASONS = ["Timer too close", "Move queue overflow", "Missed scheduling of next digital out event", "Command request"]
DESCRIBED = {
    "version": "small board of the tests",
    "app": "Klipper",
    "commands": {"identify offset=%u count=%c": 1} | {text: n for n, text in enumerate(COMMANDS, 2)},
    "responses": {"identify_response offset=%u data=%.*s": 0} | {text: n for n, text in enumerate(RESPONSES, 40)},
    "config": {"CLOCK_FREQ": 16_000_000, "MCU": "small", "RECEIVE_WINDOW": 192, "RESERVE_PINS_serial": "P0,P1"},
    "enumerations": {"pin": {"P0": [0, 32]}, "static_string_id": {text: n for n, text in enumerate(REASONS, 2)}},
}


class ShutdownError(Exception):
    """The firmware stops all axes."""


class SmallBoard:
    """A simulated board; `run_to` advances its clock.  `drift`: relative error of the clock."""

    def __init__(self, drift=0.0, moves=500, start=0xFFF0_0000):
        self.hz, self.start, self.ticks = 16e6 * (1 + drift), start, start
        self.moves = moves
        self.levels = dict.fromkeys(range(32), 0)
        self.pulses = {}  # a list of (tick, direction) of the pulses of each step pin
        self.positions = {}
        self._reader, self._expected, self.out = frames.Reader(), 0, bytearray()
        self._later, self._order = [], count()
        self._packed = zlib.compress(json.dumps(DESCRIBED).encode())
        self._dictionary = Dictionary(DESCRIBED)
        self._by_number = {each.number: each for each in self._dictionary.commands.values()}
        self._answers = {text.split()[0]: (n, text) for text, n in DESCRIBED["responses"].items()}
        self._asked_again = False
        self.off()

    def off(self):
        self.oids, self.crc, self.configured, self.shutdown, self.endstops = {}, 0, False, 0, []

    # Time

    def at(self, ticks, action):
        heapq.heappush(self._later, (ticks, next(self._order), action))

    def run_to(self, seconds):
        """Advance to this time of the host's clock."""
        end = self.start + round(seconds * self.hz)
        self._look()
        while self._later and self._later[0][0] <= end:
            self.ticks, _, action = heapq.heappop(self._later)
            try:
                action()
            except ShutdownError as reason:
                self._stop(str(reason))
            self._look()
        self.ticks = end

    def _look(self):
        """Let the endstops look at their levels, which change only at events or between two calls of `run_to`."""
        for endstop in self.endstops:
            endstop.look()

    def time_s(self, ticks):
        return (ticks - self.start) / self.hz

    def _full(self, clock):
        return self.ticks + ((clock - self.ticks + (1 << 31)) % (1 << 32)) - (1 << 31)

    # Frames

    def receive(self, data):
        for sequence, content in self._reader.feed(data):
            if sequence == self._expected:
                self._expected = (sequence + 1) & 15
                self._dispatch(content)
            self.out += frames.block(self._expected, b"")

    def transmitted(self):
        data, self.out = bytes(self.out), bytearray()
        return data

    def responses(self, now):
        """Return the bytes since the last call with their time: the board's clock may be read with an error."""
        return [(now, self.transmitted())]

    def _answer(self, name, *values):
        number, _ = self._answers[name]
        parts = [frames.integer(v) if isinstance(v, int) else frames.integer(len(v)) + v for v in values]
        self.out += frames.block(self._expected, frames.integer(number) + b"".join(parts))

    def _dispatch(self, content):
        at = 0
        while at < len(content):
            number, at = frames.read_integer(content, at)
            command, values = self._by_number[number], []
            for _ in command.parameters:
                value, at = frames.read_integer(content, at)
                values.append(value)
            if self.shutdown and command.name not in ("identify", "get_config", "get_clock", "clear_shutdown"):
                self._answer("is_shutdown", self.shutdown)
                continue
            try:
                getattr(self, f"do_{command.name}")(*values)
            except ShutdownError as reason:
                self._stop(str(reason))

    def _stop(self, reason):
        self.shutdown = REASONS.index(reason) + 2
        for part in self.oids.values():
            part.stop()
        self._answer("shutdown", self.ticks & 0xFFFF_FFFF, self.shutdown)

    # Commands

    def do_identify(self, offset, size):
        self._answer("identify_response", offset, self._packed[offset : offset + size])

    def do_get_config(self):
        self._answer("config", int(self.configured), self.crc, int(bool(self.shutdown)), self.moves)

    def do_get_clock(self):
        self._answer("clock", self.ticks & 0xFFFF_FFFF)

    def do_emergency_stop(self):
        raise ShutdownError("Command request")

    def do_clear_shutdown(self):
        self.shutdown = 0

    def do_allocate_oids(self, number):
        self.oids, self.endstops = {}, []

    def do_finalize_config(self, crc):
        self.crc, self.configured = crc & 0xFFFF_FFFF, True

    def do_config_stepper(self, oid, step, direction, invert, pulse):
        self.oids[oid] = Stepper(self, step, direction)

    def do_config_endstop(self, oid, pin, pull_up):
        self.oids[oid] = Endstop(self, pin)
        self.endstops.append(self.oids[oid])

    def do_config_trsync(self, oid):
        self.oids[oid] = Trsync(self, oid)

    def do_config_digital_out(self, oid, pin, value, default, most):
        self.oids[oid] = Output(self, pin, value, default, most & 0xFFFF_FFFF)

    def do_queue_step(self, oid, interval, number, add):
        self.oids[oid].queue(interval & 0xFFFF_FFFF, number, add)
        if sum(len(part.waiting) for part in self.oids.values() if isinstance(part, Stepper)) > self.moves:
            raise ShutdownError("Move queue overflow")

    def do_set_next_step_dir(self, oid, direction):
        self.oids[oid].next_direction = direction

    def do_reset_step_clock(self, oid, clock):
        stepper = self.oids[oid]
        assert not stepper.active, "the step clock is reset at rest"
        stepper.last, stepper.needs_reset = self._full(clock), False

    def do_stepper_get_position(self, oid):
        self._answer("stepper_position", oid, self.oids[oid].position)

    def do_stepper_stop_on_trigger(self, oid, trsync):
        self.oids[trsync].steppers.append(self.oids[oid])

    def do_trsync_start(self, oid, clock, ticks, reason):
        self.oids[oid].armed, self.oids[oid].steppers = True, []

    def do_trsync_trigger(self, oid, reason):
        self.oids[oid].trigger(reason)
        self._answer("trsync_state", oid, 0, self.oids[oid].reason, 0)

    def do_endstop_home(self, oid, clock, sample, number, rest, level, trsync, reason):
        self.oids[oid].home(self._full(clock), number, rest, level, self.oids.get(trsync), reason)

    def do_endstop_query_state(self, oid):
        endstop = self.oids[oid]
        homing = int(endstop.trsync is not None)
        self._answer("endstop_state", oid, homing, endstop.next & 0xFFFF_FFFF, self.levels[endstop.pin])

    def do_update_digital_out(self, oid, value):
        self.oids[oid].update(value)

    def do_queue_digital_out(self, oid, clock, on):
        self.at(self._full(clock), lambda: self.oids[oid].update(on))


class Stepper:
    def __init__(self, board, step, direction):
        self.board, self.step, self.direction = board, step, 0
        self.next_direction, self.last, self.position, self.needs_reset = 0, 0, 0, True
        self.waiting, self.active, self.era = [], False, 0
        board.pulses.setdefault(step, [])

    def queue(self, interval, number, add):
        assert number > 0, "a command has pulses"
        if self.needs_reset and not self.active:
            return
        self.waiting.append([interval, number, add, self.next_direction])
        if not self.active:
            self._load()

    def _load(self):
        self.active = bool(self.waiting)
        if self.active:
            self.now = self.waiting.pop(0)
            self._plan()

    def _plan(self):
        due = self.last + self.now[0]
        if due < self.board.ticks - 16:
            raise ShutdownError("Timer too close")
        era = self.era
        self.board.at(due, lambda: self._pulse(due, era))

    def _pulse(self, due, era):
        if era != self.era:
            return
        interval, number, add, direction = self.now
        self.last = due
        self.position += 1 if direction else -1
        self.board.pulses[self.step].append((due, 1 if direction else -1))
        self.now = [interval + add, number - 1, add, direction]
        if number > 1:
            self._plan()
        else:
            self._load()

    def stop(self):
        self.era += 1
        self.waiting, self.active, self.needs_reset, self.next_direction = [], False, True, 0


class Trsync:
    def __init__(self, board, oid):
        self.board, self.oid, self.armed, self.steppers, self.reason = board, oid, False, [], 0

    def trigger(self, reason):
        if self.armed:
            self.armed, self.reason = False, reason
            for stepper in self.steppers:
                stepper.stop()
            self.board._answer("trsync_state", self.oid, 0, reason, self.board.ticks & 0xFFFF_FFFF)

    def stop(self):
        self.armed, self.steppers = False, []


class Endstop:
    """An input that is sampled at tick `first` and each `rest` ticks later, until it has a level."""

    def __init__(self, board, pin):
        self.board, self.pin, self.trsync, self.sampled, self.ended, self.due = board, pin, None, False, 0, False

    @property
    def next(self):
        if not self.sampled:
            return self.ended
        return self.first + max(0, (self.board.ticks - self.first) // self.rest + 1) * self.rest

    def home(self, clock, number, rest, level, trsync, reason):
        self.trsync, self.sampled, self.due = trsync if number else None, bool(number), False
        self.first, self.rest, self.level, self.reason = max(clock, self.board.ticks), rest, level, reason

    def look(self):
        """Plan the trigger by the next sample if the input has the level."""
        if self.sampled and not self.due and self.board.levels[self.pin] == self.level:
            self.due = True
            first = self.first
            self.board.at(max(self.next, first), lambda: self._sample(first))

    def _sample(self, first):
        if not self.sampled or first != self.first:
            return
        self.due = False
        if self.board.levels[self.pin] == self.level:
            self.sampled, self.ended = False, self.board.ticks + self.rest
            self.trsync.trigger(self.reason)

    def stop(self):
        self.sampled, self.ended = False, self.board.ticks


class Output:
    def __init__(self, board, pin, value, default, most):
        self.board, self.pin, self.default, self.most, self.era = board, pin, default, most, 0
        board.levels[pin] = value

    def update(self, value):
        self.era += 1
        self.board.levels[self.pin] = int(bool(value))
        if bool(value) != bool(self.default) and self.most:
            era = self.era
            self.board.at(self.board.ticks + self.most, lambda: self._expire(era))

    def _expire(self, era):
        if era == self.era:
            raise ShutdownError("Missed scheduling of next digital out event")

    def stop(self):
        self.era += 1
        self.board.levels[self.pin] = self.default
