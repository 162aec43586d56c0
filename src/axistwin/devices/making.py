"""From a class of a device to a model of the bench, and the hardware around an object of the class."""

import inspect
import json
import traceback
from collections.abc import Generator, Mapping, Sequence
from dataclasses import make_dataclass
from functools import cache, partial
from logging import getLogger
from math import inf
from pathlib import Path
from typing import Any, Literal

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.front import Group, Lamp, Word
from axistwin.controllers.options import check
from axistwin.controllers.product import Abilities, Product, Refusal, Register, Store
from axistwin.core.errors import UsageError, one_line
from axistwin.core.units import to_ns
from axistwin.devices.checking import RULES, checker_of, listing
from axistwin.devices.device import Device, Input, Option, Output, State
from axistwin.devices.framing import Lines, Port, Request
from axistwin.devices.table import Entry, Refused, Why, attributes, check_table, collected
from axistwin.plant.axes import stepper_axis
from axistwin.plant.positioner import Positioner
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
    if not isinstance(getattr(kind, "model", None), str):
        raise UsageError(f'{_place(kind)}: class {kind.__name__} has no model: add one, e.g. model = "stage"')
    _check_names(kind)
    entries = list(collected(kind))
    lines = kind.framing if isinstance(kind.framing, Lines) else None
    check_table(
        entries, kind.framing.fields,
        lambda entry, line: lines is not None and lines.compiled(entry, kind.axes).fullmatch(line) is not None,
        next(iter(kind.axes), ""),
    )  # fmt: skip
    if lines and not lines.address and (empty := [entry for entry in entries if not entry.pattern.parts]):
        raise UsageError(f"{empty[0].place}: an empty pattern needs an address: without one empty lines are ignored")
    names = [*kind.axes, *kind.options]
    if taken := [name for name in names if name in RESERVED or names.count(name) > 1]:
        raise UsageError(f"{_place(kind)}: the name {taken[0]!r} of an axis or option is in use: choose another")
    for name, axis in kind.axes.items():
        if bool(axis.minus) is not bool(axis.plus):
            raise UsageError(f"{_place(kind)}: axis {name} has one limit input: name two, an unused Input(level=True)")
        for pin in filter(None, (axis.minus, axis.plus, axis.home)):
            if not isinstance(kind.pins.get(pin), Input):
                raise UsageError(
                    f"{_place(kind)}: axis {name} names {pin!r}: add it to the pins, e.g. {pin!r}: Input(level=True)"
                )
    options = _options(kind)
    _check_texts(kind)
    return Product(
        kind.model, kind.title or kind.__name__, CommandSet(*entries), tuple(kind.axes),
        options, lambda clock, axes, given, store: Hardware(kind, entries, clock, axes, given, store),
        make_axis=lambda clock, name, given, history: _axis(kind.axes[name], clock, name, given, history),
        line=line_format(kind.line, UartFormat())[0],
        limit_pins={name: (axis.minus, axis.plus) for name, axis in kind.axes.items() if axis.minus and axis.plus},
        home_pins={name: axis.home for name, axis in kind.axes.items() if axis.home},
        endings=kind.framing.endings, make_front=lambda: _front(kind), driver=kind,
        check=checker_of(kind, entries, _address(kind, {})), make_rules=lambda: RULES,
        check_for=lambda given: checker_of(kind, entries, _address(kind, given)),
        phrase=lambda entry, values: kind.framing.phrase(entry, values, _address(kind, {})),
    )  # fmt: skip


def _axis(positioner: Positioner, clock: Clock, name: str, given: Mapping[str, Any], history: int) -> Any:
    axis = stepper_axis(clock, name, given, history)
    axis.unit = "counts" if positioner.servo else "pulses"
    return axis


def _check_names(kind: type[Device]) -> None:
    """Refuse an attribute that is one letter off one of Device's, which nothing would read."""
    own = {name: value for base in kind.__mro__ if base not in Device.__mro__ for name, value in vars(base).items()}
    for name, value in own.items():
        if hasattr(value, "entries") or hasattr(value, "state") or hasattr(Device, name):
            continue
        for known in HOOKS if inspect.isfunction(value) else FIGURES:
            if known not in own and _one_off(name, known):
                raise UsageError(
                    f"{_place(kind)}: nothing reads {name!r} of class {kind.__name__}: did you mean {known!r}? "
                    f"If not, call it _{name}"
                )


def _one_off(one: str, other: str) -> bool:
    """Return True if a letter is missing, more, wrong, or two are exchanged."""
    same = next((at for at, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    one, other = one[same:], other[same:]
    return other in (one[1:], one[1::-1] + one[2:]) or other[1:] in (one, one[1:])


def _check_texts(kind: type[Device]) -> None:
    try:
        _address(kind, {})
        json.dumps(dict(kind.memory))
    except (LookupError, ValueError) as error:
        raise UsageError(
            f"{_place(kind)}: invalid address {kind.framing.address!r}: {error}: expected the name of an option, "
            'e.g. "{address:02d}"'
        ) from None
    except TypeError as error:
        raise UsageError(
            f"{_place(kind)}: invalid memory: {error}: expected numbers, texts, lists and dictionaries"
        ) from None


def _address(kind: type[Device], given: Mapping[str, Any]) -> bytes:
    usual = {name: option.usual for name, option in kind.options.items()}
    try:
        return kind.framing.address.format(**{**usual, **given}).encode("latin-1")
    except (LookupError, ValueError, TypeError):  # Options of a scene that is wrong.
        return kind.framing.address.format(**usual).encode("latin-1")


def _options(kind: type[Device]) -> type[Any]:
    made: list[Any] = []
    for name, option in kind.options.items():
        if not isinstance(option, Option) or type(option.usual) not in (int, float, str, bool):
            raise UsageError(
                f"{_place(kind)}: option {name} is {option!r}: expected Option(...), e.g. Option(1, 1, 255)"
            )
        made.append((name, Literal[option.choices] if option.choices else type(option.usual), option.usual))
    ranges = {
        name: (-inf if option.low is None else option.low, inf if option.high is None else option.high)
        for name, option in kind.options.items()
        if not isinstance(option.usual, str)
    }

    def check_all(made: Any) -> None:
        check(made, ranges)
        for name, option in kind.options.items():
            if isinstance(option.usual, str) and not isinstance(getattr(made, name), str):
                raise UsageError(f"{name}={getattr(made, name)!r}: expected a text, e.g. {option.usual!r}")

    return make_dataclass("Options", made, namespace={"__post_init__": check_all})


def _states(kind: type[Device]) -> dict[str, State]:
    return {name: method.state for name, method in attributes(kind).items() if hasattr(method, "state")}


def _front(kind: type[Device]) -> tuple[Group, ...]:
    groups = []
    for name, (bits, section, _) in _states(kind).items():
        lamps = tuple(Lamp(str(bit), words, name, bit) for bit, words in sorted(bits.items()))
        groups.append(
            Group(name.replace("_", " "), section, lamps or (Word(name, name.replace("_", " "), name),), row=False)
        )
    if kind.pins:
        groups.append(Group("Terminals", "", tuple(Lamp(name, name, name) for name in kind.pins)))
    return tuple(groups)


class Hardware:
    """A device with its terminals, its serial line and its power switch."""

    def __init__(
        self, kind: type[Device], entries: Sequence[Entry], clock: Clock, axes: Mapping[str, Any], options: Any,
        store: Store,
    ) -> None:  # fmt: skip
        self.kind, self.entries, self.clock, self.axes, self.store = kind, entries, clock, axes, store
        self.options = {name: getattr(options, name) for name in kind.options}
        self.pins = {n: Pin(clock, n, pin.level, output=isinstance(pin, Output)) for n, pin in kind.pins.items()}
        self.uart = Uart(clock)
        self.uart.format = line_format(kind.line, UartFormat())[0]
        self._find = kind.framing.finder(entries, axes)
        self._address = _address(kind, self.options)
        self.alarms = Alarms(*kind.faults)
        self.refusals: Signal[[Refusal]] = Signal()
        self.device: Device | None = None
        self._logged: set[str] = set()  # File and line of the errors that have been logged.
        self.running: list[Process] = []
        self._ends: list[Any] = []
        self._waiting: list[tuple[bytes, Refused | None]] = []
        self._blocked = False
        self.abilities = Abilities(
            uart=self.uart, alarms=self.alarms, registers=self._registers, hint=self._hint,
            awaited=lambda: getattr(self.device, "awaited", None), subscribe_refusals=self.refusals.subscribe,
            busy=lambda: bool(self._blocked or any(axis.moving for axis in getattr(self.device, "axes", {}).values())),
            procedures=lambda: self.running,
        )  # fmt: skip

    # Power

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
            self.device, self.running, self._ends, self._blocked = None, [], [], False
            self._waiting.clear()
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
        for name, pin in self.pins.items():
            if not pin.is_output:
                self._ends.append(pin.subscribe(partial(self._pin_changed, name)))
        result = self._guarded(device.start, b"")
        if isinstance(result, Generator):
            self._begin(result).callbacks.append(lambda _: self._listen(device))
        else:
            self._listen(device)

    def _listen(self, device: Device) -> None:
        if device is self.device:
            port = Port(self._address, self._take, self.uart.send, lambda: self.clock.now)
            self.uart.on_receive = self.kind.framing.reader(port)

    def _pin_changed(self, name: str, pin: Pin) -> None:
        self._react("pin_changed", name, pin.level)

    def _react(self, method: str, *values: Any) -> None:
        if self.device is not None:
            result = self._guarded(partial(getattr(self.device, method), *values), b"")
            if isinstance(result, Generator):
                self._begin(result)

    def _fault(self, name: str) -> None:
        if name not in self.kind.faults:
            raise ValueError(f"no fault {name!r}: expected one of {', '.join(self.kind.faults) or 'faults = (…)'}")
        self.alarms.emit(name)

    # Requests

    def _take(self, data: bytes, wrong: Refused | None) -> None:
        if self.device is None:  # An earlier request of the same line has switched the power off.
            return
        if self._blocked and len(self._waiting) < MOST_WAITING:
            self._waiting.append((data, wrong))
        elif self._blocked:
            self._refuse(data, Refused("too many requests wait", why=Why.STATE))
        else:
            self._obey(data, wrong)

    def _obey(self, data: bytes, wrong: Refused | None) -> None:
        device = self.device
        assert device is not None, "without power no request is read"
        entry = None
        try:
            if wrong is not None:
                raise wrong
            request = self._find(data)
            entry = request.entry
            wanted = {name: request.values[name] for name in request.entry.wanted}
            result = request.entry.handler(device, **wanted)  # type: ignore[misc]  # all entries have handlers
        except Refused as reason:
            self._refuse(data, reason, entry or (reason.entry if reason.why is Why.RANGE else None))
            return
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._refuse(data, _bug(self.kind, error), entry)
            return
        if isinstance(result, Generator):
            self._blocked = request.entry.blocks
            self._begin(result, request)
        else:
            self._reply(request, result)

    def _reply(self, request: Request, result: Any) -> None:
        if self.device is None:  # The request has switched the power off.
            return
        entry = request.entry
        try:
            answer = self.device.answer(result, request)
            if answer is None:
                if entry.asks:
                    raise TypeError("returned None: a query answers with text, a number or bytes")
                return
            self._send(answer, entry.after_s)
        except Refused as reason:
            self._refuse(request.data, reason, entry)
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._refuse(request.data, _bug(self.kind, error, entry.place), entry)

    def _refuse(self, data: bytes, reason: Refused, entry: Entry | None = None) -> None:
        self._tell(reason, data)
        answer = self._guarded(lambda: self.device and self.device.refused(reason, data), data)
        if answer is not None:
            self._guarded(partial(self._send, answer, entry.after_s if entry else None), data)

    def _send(self, answer: Any, after_s: float | None = None) -> None:
        data = self.kind.framing.written(answer)
        delay_ns = to_ns(self.kind.answer_after if after_s is None else after_s)
        if delay_ns:
            device = self.device
            self.clock.call_later(delay_ns, lambda: self.uart.send(data) if device is self.device else None)
        else:
            self.uart.send(data)

    # Procedures, and errors of a device

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
        except Refused as reason:
            self._refuse(data, reason, entry)
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._refuse(data, _bug(self.kind, error), entry)
        if entry is not None and entry.blocks:
            self._blocked = False
            while self._waiting and not self._blocked:
                self._obey(*self._waiting.pop(0))

    def _guarded(self, act: Any, data: bytes) -> Any:
        try:
            return act()
        except Exception as error:  # noqa: BLE001  # an error of a device must not end the bench
            self._tell(_bug(self.kind, error), data)
            return None

    def _tell(self, reason: Refused, data: bytes) -> None:
        """Report what is refused, and log the first error of each line: a register may be read 20 times a second."""
        place = reason.words.partition(": ")[0]
        if data or place not in self._logged:
            remedy = f": {listing(self.kind)}" if reason.why is Why.UNKNOWN else ""
            self.refusals.emit(Refusal(data, reason.words + remedy))
        if reason.why is Why.BUG and place not in self._logged:
            self._logged.add(place)
            _log.error("%s", reason.words)

    def _hint(self) -> str:
        return self._guarded(lambda: "" if self.device is None else self.device.hint(), b"") or ""

    def _registers(self) -> Mapping[str, Register]:
        def read(name: str, text: bool) -> Any:
            value = None if self.device is None else self._guarded(getattr(self.device, name), b"")
            return value if value is not None else "off" if text else 0

        texts = {
            name: getattr(self.kind, name).__annotations__.get("return") in (str, "str") for name in _states(self.kind)
        }
        return {
            name: Register(partial(read, name, texts[name]), text=texts[name], restless=state.restless)
            for name, state in _states(self.kind).items()
        }


def _steps(steps: Generator[Any, Any, Any]) -> Procedure:
    try:
        value = None
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
    finally:
        steps.close()


def _recalled(store: Store, factory: Mapping[str, Any]) -> dict[str, Any]:
    contents = store.load()
    try:
        found = {} if contents is None else json.loads(contents)
    except ValueError:  # The file of another device, or a damaged one: a device begins with its factory settings.
        found = {}
    kept = {name: found[name] for name in factory if name in found} if isinstance(found, dict) else {}
    copied: dict[str, Any] = json.loads(json.dumps(dict(factory)))
    return {**copied, **kept}


def _bug(kind: type[Device], error: Exception, place: str = "") -> Refused:
    """Return an error in a handler as a reason that names its line, of the deepest frame in the device's own file."""
    own = _files(kind)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in own]
    where = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else place or _place(kind)
    return Refused(one_line(f"{where}: {type(error).__name__} in {kind.model}: {error}: mend the handler"), why=Why.BUG)


def _files(kind: type[Device]) -> list[str]:
    own = (method for base in kind.__mro__ if base is not Device for method in vars(base).values())
    return [method.__code__.co_filename for method in own if inspect.isfunction(method)]


def _place(kind: type[Device]) -> str:
    name = Path((*_files(kind), kind.__module__)[0]).name
    try:
        return f"{name}:{inspect.getsourcelines(kind)[1]}"
    except (OSError, TypeError):  # A class that was typed, or made by a function, has no source.
        return name
