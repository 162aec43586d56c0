"""From a class of a device to a model of the bench, and the hardware around an object of the class."""

import inspect
import json
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from functools import cache, partial
from itertools import combinations
from logging import getLogger
from pathlib import Path
from typing import Any

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.files import files_of, line_in, listing, place_of
from axistwin.controllers.front import Status, front_of
from axistwin.controllers.options import Option, options_class
from axistwin.controllers.patterns import Refused, Why
from axistwin.controllers.product import Abilities, Product, Refusal, Register, Store
from axistwin.core.errors import UsageError, one_letter_off, one_line
from axistwin.core.units import to_ns
from axistwin.devices.device import Device, Input, Output
from axistwin.devices.framing import Framing, Port, Request
from axistwin.devices.table import Entry, attributes, collected
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill
from axistwin.sim.frames import UartFormat
from axistwin.sim.line_format import line_format
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Alarms, Signal

MOST_WAITING = 64  # Largest number of requests that wait for a procedure that blocks.
RESERVED = "model", "name", "state", "line", "history"  # Keywords of `Bench.add`.
FIGURES = "title", "line", "framing", "axes", "pins", "options", "memory", "faults", "driver", "answer_after"
HOOKS = "start", "answer", "refused", "pin_changed", "limit_reached", "hint"
_log = getLogger("axistwin.devices")


@cache
def product_of(kind: type[Device]) -> Product:
    """Return the model of a class.  Raises UsageError for a class whose table or figures are wrong."""
    for problem in _problems(kind):
        raise UsageError(f"{place_of(kind, Device)}: {problem}")
    entries, framing = list(collected(kind)), kind.framing
    for problem in _problems_of_table(entries, framing, kind.axes):
        raise UsageError(problem)
    return Product(
        kind.model, kind.title or kind.__name__, CommandSet(*entries), tuple(kind.axes),
        options_class(kind.options), partial(Hardware, kind, entries), line=line_format(kind.line, UartFormat())[0],
        limit_pins={name: (axis.minus, axis.plus) for name, axis in kind.axes.items() if axis.minus},
        home_pins={name: axis.home for name, axis in kind.axes.items() if axis.home},
        endings=framing.endings, make_front=lambda: front_of(_registers(kind), kind.pins), driver=kind,
        phrase=lambda entry, values: framing.phrase(entry, values, address_of(kind, {})),
    )  # fmt: skip


def _problems(kind: type[Device]) -> Iterator[str]:
    if not isinstance(getattr(kind, "model", None), str):
        yield f'class {kind.__name__} has no model: add one, e.g. model = "stage"'
    yield from _misspelt(kind)
    names = [*kind.axes, *kind.options]
    for name in names:
        if name in RESERVED or names.count(name) > 1:
            yield f"the name {name!r} of an axis or option is in use: choose another"
    for name, axis in kind.axes.items():
        if bool(axis.minus) is not bool(axis.plus):
            yield f"axis {name} has one limit input: name two, an unused Input(level=True)"
        for pin in filter(None, (axis.minus, axis.plus, axis.home)):
            if not isinstance(kind.pins.get(pin), Input):
                yield f"axis {name} names {pin!r}: add it to the pins, e.g. {pin!r}: Input(level=True)"
    for name, option in kind.options.items():
        if not isinstance(option, Option) or type(option.usual) not in (int, float, str, bool):
            yield f"option {name} is {option!r}: expected Option(...), e.g. Option(1, 1, 255)"
    try:
        address_of(kind, {})
    except (LookupError, ValueError) as error:
        what = f"invalid address {kind.framing.address!r}: {error}"
        yield f'{what}: expected the name of an option, e.g. "{{address:02d}}"'
    try:
        json.dumps(dict(kind.memory))
    except (TypeError, ValueError) as error:
        yield f"invalid memory: {error}: expected numbers, texts, lists and dictionaries"


def _misspelt(kind: type[Device]) -> Iterator[str]:
    """Yield the attributes that are one letter off one of Device's, which nothing would read."""
    own = {name: value for base in kind.__mro__ if base not in Device.__mro__ for name, value in vars(base).items()}
    for name, value in own.items():
        if hasattr(value, "entries") or hasattr(value, "status") or hasattr(Device, name):
            continue
        for known in HOOKS if inspect.isfunction(value) else FIGURES:
            if known not in own and one_letter_off(name, known):
                words = f"nothing reads {name!r} of class {kind.__name__}: did you mean {known!r}?"
                yield f"{words} If not, call it _{name}"


def _problems_of_table(entries: Sequence[Entry], framing: Framing, axes: Mapping[str, Any]) -> Iterator[str]:
    for entry, other in combinations(entries, 2):
        if (lines := framing.shared(entry, other, axes)) or entry.code == other.code:
            what = f"{other.place}: {other.code!r} also matches {(*lines, entry.code)[0]!r}"
            yield f"{what}, as {entry.code!r} does at {entry.place}: change one of the patterns"
    for entry in entries:
        for name in entry.wanted:
            if name not in (*framing.fields, *(parameter.name for parameter in entry.parameters)):
                yield f"{entry.place}: the pattern {entry.code!r} has no {{{name}}}: add it, or remove the parameter"
        for problem in framing.problems(entry):
            yield f"{entry.place}: {problem}"


def address_of(kind: type[Device], given: Mapping[str, Any]) -> bytes:
    """Return what the requests for a device with these options begin with; other options have their usual values."""
    usual = {name: option.usual for name, option in kind.options.items()}
    return kind.framing.address.format(**{**usual, **given}).encode("latin-1")


def _registers(kind: type[Device]) -> dict[str, Status]:
    return {name: method.status for name, method in attributes(kind).items() if hasattr(method, "status")}


class Hardware:
    """A device with its terminals, its serial line and its power switch."""

    def __init__(
        self, kind: type[Device], entries: Sequence[Entry], clock: Clock, axes: Mapping[str, Any], options: Any,
        store: Store,
    ) -> None:  # fmt: skip
        self.kind, self.clock, self.axes, self.store = kind, clock, axes, store
        self.options = {name: getattr(options, name) for name in kind.options}
        self.pins = {n: Pin(clock, n, pin.level, output=isinstance(pin, Output)) for n, pin in kind.pins.items()}
        self.uart = Uart(clock, line_format(kind.line, UartFormat())[0])
        self._find = kind.framing.finder(entries, axes)
        self.alarms = Alarms(*kind.faults)
        self.refusals: Signal[[Refusal]] = Signal()
        self.device: Device | None = None
        self._logged: set[str] = set()  # File and line of the errors that have been logged.
        self.running: list[Process] = []
        self._ends: list[Any] = []
        self._waiting: list[tuple[bytes, Refused | None]] = []
        self._blocked = False
        self.abilities = Abilities(
            uart=self.uart, alarms=self.alarms, registers=self._registers, subscribe_refusals=self.refusals.subscribe,
            hint=lambda: self._guarded(lambda: "" if self.device is None else self.device.hint()) or "",
            awaited=lambda: getattr(self.device, "awaited", None),
            busy=lambda: bool(self._blocked or any(axis.moving for axis in getattr(self.device, "axes", {}).values())),
            procedures=lambda: self.running,
        )  # fmt: skip

    def power(self, on: bool) -> None:
        if on and self.device is None:
            self._switch_on()
        elif not on and self.device is not None:
            for process in self.running:
                kill(process)
            for end in (*self._ends, *(axis.disconnect for axis in self.device.axes.values())):
                end()
            for name, pin in self.kind.pins.items():
                if isinstance(pin, Output):
                    self.pins[name].set(pin.level)
            self.device, self.running, self._ends, self._waiting, self._blocked = None, [], [], [], False
            self.uart.queue.clear()
            self.uart.on_receive = lambda byte, errors: None

    def _switch_on(self) -> None:
        kind, device = self.kind, self.kind()
        self.device = device
        device.clock, device.options, device.pins = self.clock, self.options, self.pins
        device.memory = _recalled(self.store, kind.memory)
        device.send, device.fault, device.begin = partial(self._send, after_s=0.0), self._fault, self._begin
        device.save = lambda: self.store.save(json.dumps(device.memory).encode())
        device.axes = {
            name: spec.connect(self.axes[name], self.pins, partial(self._react, "limit_reached", name))
            for name, spec in kind.axes.items()
        }
        self._ends = [pin.subscribe(self._pin_changed) for pin in self.pins.values() if not pin.is_output]

        def listen(_: Any = None) -> None:
            if device is self.device:
                port = Port(address_of(kind, self.options), self._take, self.uart.send, lambda: self.clock.now)
                self.uart.on_receive = kind.framing.reader(port)

        if begun := self._react("start"):
            begun.callbacks.append(listen)
        else:
            listen()

    def _pin_changed(self, pin: Pin) -> None:
        self._react("pin_changed", pin.name, pin.level)

    def _react(self, hook: str, *values: Any) -> Process | None:
        """Call a method of the device; if it is a generator, begin and return the procedure."""
        if self.device is None:
            return None
        result = self._guarded(partial(getattr(self.device, hook), *values))
        return self._begin(result) if isinstance(result, Generator) else None

    def _fault(self, name: str) -> None:
        if name not in self.kind.faults:
            raise ValueError(f"no fault {name!r}: expected one of {', '.join(self.kind.faults) or 'faults = (…)'}")
        self.alarms.emit(name)

    def _registers(self) -> Mapping[str, Register]:
        def read(name: str, absent: int | str) -> Any:
            value = None if self.device is None else self._guarded(getattr(self.device, name))
            return absent if value is None else value

        return {
            name: Register(partial(read, name, "off" if status.text else 0), text=status.text, restless=status.restless)
            for name, status in _registers(self.kind).items()
        }

    def _take(self, data: bytes, wrong: Refused | None) -> None:
        if self.device is None:  # An earlier request of the same line has switched the power off.
            return
        if not self._blocked:
            self._obey(data, wrong)
        elif len(self._waiting) < MOST_WAITING:
            self._waiting.append((data, wrong))
        else:
            self._refuse(data, Refused("too many requests wait"))

    def _obey(self, data: bytes, wrong: Refused | None) -> None:
        entry = None
        try:
            if wrong is not None:
                raise wrong
            request = self._find(data)
            entry = request.entry
            wanted = {name: request.values[name] for name in entry.wanted}
            result = entry.handler(self.device, **wanted)  # type: ignore[misc]  # all entries have handlers
            if isinstance(result, Generator):
                self._blocked = entry.blocks
                self._begin(result, request)
            else:
                self._reply(request, result)
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._refuse(data, error, entry)

    def _reply(self, request: Request, result: Any) -> None:
        if self.device is None:  # The request has switched the power off.
            return
        answer = self.device.answer(result, request)
        if answer is not None:
            self._send(answer, request.entry.after_s)
        elif request.entry.asks:
            raise TypeError("returned None: a query answers with text, a number or bytes")

    def _refuse(self, data: bytes, error: Exception, entry: Entry | None = None) -> None:
        reason = error if isinstance(error, Refused) else _bug(self.kind, error, entry.place if entry else "")
        entry = entry or (reason.entry if reason.why is Why.RANGE else None)

        def answer() -> None:
            if self.device is not None and (made := self.device.refused(reason, data)) is not None:
                self._send(made, entry.after_s if entry else None)

        self._tell(reason, data)
        self._guarded(answer, data)

    def _send(self, answer: Any, after_s: float | None = None) -> None:
        data, device = self.kind.framing.written(answer), self.device
        delay_ns = to_ns(self.kind.answer_after if after_s is None else after_s)
        if delay_ns:
            self.clock.call_later(delay_ns, lambda: self.uart.send(data) if device is self.device else None)
        else:
            self.uart.send(data)

    def _begin(self, steps: Generator[Event, Any, Any], request: Request | None = None) -> Process:
        process: Process = self.clock.process(self._carry_out(steps, request))
        self.running = [one for one in self.running if one.is_alive] + [process]
        return process

    def _carry_out(self, steps: Generator[Event, Any, Any], request: Request | None) -> Procedure:
        data, entry = (request.data, request.entry) if request else (b"", None)
        try:
            result = yield from _steps(steps)
            if request is not None:
                self._reply(request, result)
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._refuse(data, error, entry)
        if entry is not None and entry.blocks:
            self._blocked = False
            while self._waiting and not self._blocked:
                self._obey(*self._waiting.pop(0))

    def _guarded(self, act: Any, data: bytes = b"") -> Any:
        try:
            return act()
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._tell(_bug(self.kind, error), data)
            return None

    def _tell(self, reason: Refused, data: bytes) -> None:
        """Report what is refused, and log the first error of each line: a register may be read 20 times a second."""
        place = reason.words.partition(": ")[0]
        if data or place not in self._logged:
            remedy = f": {listing(self.kind.model)}" if reason.why is Why.UNKNOWN else ""
            self.refusals.emit(Refusal(data, reason.words + remedy))
        if reason.why is Why.BUG and place not in self._logged:
            self._logged.add(place)
            _log.error("%s", reason.words)


def _steps(steps: Generator[Any, Any, Any]) -> Procedure:
    value = None
    with closing(steps):
        while True:
            try:
                event = steps.send(value)
            except StopIteration as end:
                return end.value
            if not isinstance(event, Event):
                wrong = TypeError(f"yielded {event!r}: expected an event, e.g. self.after(0.2)")
                steps.throw(wrong)  # At its line.
                raise wrong
            value = yield event


def _recalled(store: Store, factory: Mapping[str, Any]) -> dict[str, Any]:
    """Return the memory as last saved, or as from the factory; a file of another device or a damaged one is ignored."""
    memory: dict[str, Any] = json.loads(json.dumps(dict(factory)))
    with suppress(ValueError, AttributeError):
        memory |= {name: value for name, value in json.loads(store.load() or b"{}").items() if name in memory}
    return memory


def _bug(kind: type[Device], error: Exception, place: str = "") -> Refused:
    """Return an error in a handler as a reason that names its line, of the deepest frame in the device's own file."""
    at = line_in(error, files_of(kind, Device))
    where = f"{Path(at[0]).name}:{at[1]}" if at else place or place_of(kind, Device)
    return Refused(one_line(f"{where}: {type(error).__name__} in {kind.model}: {error}: mend the handler"), why=Why.BUG)
