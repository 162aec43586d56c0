"""Protocol core of any controller, from the texts with which a host moves an axis and asks for its position.

    driver = TextDriver(move="{axis}PA{position}", stop="{axis}ST", position="{axis}TP", busy="{axis}MD")

A device of `axistwin.devices` has one as its attribute `driver`; `connect(url, MyDevice)` then moves its axes.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.drivers.axis import Status
from axistwin.drivers.core import AxisCore, Core, Line, shown
from axistwin.drivers.errors import DriverError, RefusedError, WrongAnswerError
from axistwin.drivers.steps import Procedure, Write

Said = str | Callable[..., bytes]
TIMEOUT_S = 0.5  # Beside the time that the characters take.
MOST_BITS = 64 * 11
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_TEXTS = ("move", "position", "busy", "stop", "abort", "run", "home", "define", "velocity", "begin")


def number_in(answer: bytes) -> float:
    """Return the last number in an answer.  Raises ValueError if there is none."""
    found = _NUMBER.findall(answer.decode("latin-1"))
    return float(found[-1] if found else "")


@dataclass(frozen=True)
class TextDriver:
    """What a host sends to a controller: texts with `{axis}`, `{position}`, `{velocity}` or `{direction}`.

    Instead of a text a function of these names may return the bytes, e.g. of a datagram.  `busy` asks whether an axis
    moves, and `at_rest` is the answer if it does not, or a function of the axis and the number in the answer, e.g. of
    status bits: `lambda axis, status: not int(status) & {"A": 1, "B": 2}[axis]`.  `abort`: default `stop`.  `run`: move
    until stopped.  `define`: give the position a number.  `velocity`: set that of the next moves.  `begin`: what each
    axis is told first, e.g. to switch the motor on.  `counts`: counts per unit of the numbers.
    `confirmed`: the controller also answers what is no question; as a text: with this, and all else is an error.
    `size`: length of all answers; 0: lines.  `value`: function that finds the number in an answer.
    """

    move: Said
    position: Said
    busy: Said
    stop: Said = ""
    abort: Said = ""
    run: Said = ""
    home: Said = ""
    define: Said = ""
    velocity: Said = ""
    begin: Said = ""
    at_rest: float | Callable[[str, float], bool] = 1
    counts: float = 1
    confirmed: bool | str = False
    size: int = 0
    value: Callable[[bytes], float] = number_in
    axes: Mapping[str, Any] | None = None  # By name; None: those of the device.
    terminator: bytes = b"\r"
    ending: bytes | None = None  # Terminator of answers; None: that of the requests.
    echo: bool = False
    line: str = "9600 8N1"
    address: str = ""  # What each line begins with.

    def __post_init__(self) -> None:
        for name in _TEXTS:
            text = getattr(self, name)
            try:
                isinstance(text, str) and text.format(axis="1", position=1, velocity=1, direction=1)
            except (LookupError, ValueError):
                raise UsageError(
                    f"invalid {name}={text!r} of a driver: expected only {{axis}}, {{position}}, {{velocity}} and "
                    '{direction} in braces, e.g. move="{axis}PA{position}"'
                ) from None
        if not callable(self.value):
            raise UsageError(
                f"invalid value={self.value!r} of a driver: expected a function of the bytes of an answer that returns "
                "a number, e.g. value=lambda answer: float(answer[1:])"
            )

    def said(self, name: str, **values: Any) -> bytes:
        """Return the bytes of a request.  Raises RefusedError if the controller has none of this name."""
        given = getattr(self, name)
        if callable(given):
            known = given.__code__.co_varnames[: given.__code__.co_argcount]
            return bytes(given(**{key: value for key, value in values.items() if key in known}))
        return f"{self.address}{given.format(**values)}".encode("latin-1") + self.terminator if given else b""

    def __call__(self, timeout: float = TIMEOUT_S, address: str | None = None) -> "TextCore":
        """Return the protocol core.  `address`: what each line begins with; None: as the device is delivered."""
        return TextCore(self if address is None else replace(self, address=address), timeout)


def core_of_device(device: Any) -> Callable[..., Core]:
    """Return what makes the core: the `driver` of a device, with the device's own axes and framing.

    Raises DriverError if the device does not have one.
    """
    driver, model = getattr(device, "driver", None), getattr(device, "model", device)
    if driver is None:
        raise DriverError(
            f"{model} does not say how a host moves it: expected a driver in its class, "
            'e.g. driver = TextDriver(move="{axis}PA{position}", position="{axis}TP", busy="{axis}MD")'
        )
    if isinstance(driver, TextDriver):
        framing = device.framing
        if not hasattr(framing, "terminator") and not driver.size:
            raise DriverError(
                f"{model} speaks datagrams: expected functions that return bytes, and the size of the answers, "
                "e.g. TextDriver(move=lambda axis, position: ..., size=9, value=lambda answer: ...)"
            )
        lines = {name: getattr(framing, name) for name in ("terminator", "ending", "echo") if hasattr(framing, name)}
        usual = {name: option.usual for name, option in device.options.items()}
        address = driver.address or (framing.address.format(**usual) if lines else "")
        driver = replace(driver, axes=driver.axes or device.axes, line=device.line, address=address, **lines)
    found: Callable[..., Core] = driver
    return found


class TextCore(Core):
    """A controller whose requests are templates."""

    def __init__(self, driver: TextDriver, timeout: float) -> None:
        baud, _, frame = driver.line.partition(" ")
        super().__init__(timeout + MOST_BITS / int(baud))
        self.driver = driver
        self.line = Line(int(baud), int(frame[-1:] or 1))
        self._axes = [TextAxis(self, name, spec) for name, spec in (driver.axes or {"1": None}).items()]
        self.axes = {axis.name: axis for axis in self._axes}

    def synchronise(self) -> Procedure[None]:
        """Discard what is on the line, tell the axes what comes first, and ask the first one for its position."""
        yield from self._discard(0.0)
        if self.driver.begin:
            for axis in self._axes:
                yield Write(self.driver.said("begin", axis=axis.name))
            yield from self._discard(self.timeout)
        for axis in self._axes[:1]:
            yield from axis.asked("position")

    def exchange(self, data: bytes, *, answered: bool) -> Procedure[bytes]:
        """Send a request, and return its answer without the terminator."""
        driver, request = self.driver, shown(data)
        yield Write(data)
        if driver.echo:
            yield from self._take(len(data), request)
        if not answered:
            return b""
        if driver.size:
            return (yield from self._take(driver.size, request))
        return (yield from self._until(driver.terminator if driver.ending is None else driver.ending, request))


class TextAxis(AxisCore):
    """An axis of a controller whose requests are templates."""

    def __init__(self, core: TextCore, name: str, spec: Any) -> None:
        super().__init__(
            name, velocity=float(getattr(spec, "velocity", 1000)), acceleration=float(getattr(spec, "acceleration", 1))
        )
        self._core, self._driver = core, core.driver
        self._told = self.velocity

    def asked(self, name: str) -> Procedure[float]:
        data = self._driver.said(name, axis=self.name)
        answer = yield from self._core.exchange(data, answered=True)
        try:
            return float(self._driver.value(answer))
        except Exception as error:  # noqa: BLE001  # of a function of the user's
            cause = "" if self._driver.value is number_in else f" ({type(error).__name__}: {error})"
            raise WrongAnswerError(
                f"the answer {shown(answer)} to {shown(data)} has no number{cause}: expected one, so check the "
                f"driver's `{name}` and `value`"
            ) from None

    def _tell(self, name: str, **values: Any) -> Procedure[None]:
        data = self._driver.said(name, axis=self.name, **values)
        if not data:
            raise RefusedError(f"the driver of axis {self.name} has no `{name}`: expected it in TextDriver({name}=...)")
        confirmed = self._driver.confirmed
        answer = yield from self._core.exchange(data, answered=bool(confirmed))
        if isinstance(confirmed, str) and answer != confirmed.encode("latin-1"):
            raise RefusedError(f"the answer to {shown(data)} is {shown(answer)}: expected {confirmed!r}")

    def _units(self, counts: float) -> float:
        found = counts / self._driver.counts
        return int(found) if float(found).is_integer() else found

    def move_to(self, target: int) -> Procedure[None]:
        if self._driver.velocity and self.velocity != self._told:
            yield from self._tell("velocity", velocity=self._units(self.velocity))
            self._told = self.velocity
        yield from self._tell("move", position=self._units(target))
        self._aim(target)
        self.setpoint = target

    def move_by(self, distance: int) -> Procedure[None]:
        start = self.target
        if start is None:
            start = yield from self._position()
        yield from self.move_to(start + distance)

    def _position(self) -> Procedure[int]:
        return round((yield from self.asked("position")) * self._driver.counts)

    def move_at(self, velocity: float) -> Procedure[None]:
        if not velocity:
            yield from self.stop()
            return
        yield from self._tell("run", velocity=self._units(velocity), direction=1 if velocity > 0 else -1)
        self._aim(None)

    def stop(self) -> Procedure[None]:
        yield from self._tell("stop")
        self._aim(None)

    def abort(self) -> Procedure[None]:
        yield from self._tell("abort" if self._driver.abort else "stop")
        self._aim(None)

    def home(self, direction: int) -> Procedure[None]:
        yield from self._tell("home", direction=direction)
        self._aim(None)

    def status(self) -> Procedure[Status]:
        """Ask first whether the axis moves, so that a position at rest is exact."""
        moving = not self._rests((yield from self.asked("busy")))
        position = yield from self._position()
        aim = self.target if self.target is not None else position
        velocity = self.velocity * ((aim > position) - (aim < position)) if moving else 0.0
        return self._judged(Status(position, self.setpoint, velocity, moving))

    def _rests(self, number: float) -> bool:
        if not callable(self._driver.at_rest):
            return number == self._driver.at_rest
        try:
            return bool(self._driver.at_rest(self.name, number))
        except Exception as error:  # noqa: BLE001  # of a function of the user's
            raise WrongAnswerError(
                f"the driver's `at_rest` failed for axis {self.name} and {number:g} ({type(error).__name__}: {error}): "
                'expected a function, e.g. at_rest=lambda axis, status: not int(status) & {"A": 1, "B": 2}[axis]'
            ) from None

    def set_position(self, position: int) -> Procedure[None]:
        yield from self._tell("define", position=self._units(position))
        self._aim(None)
        self.setpoint = position

    def clear_faults(self) -> Procedure[None]:
        """Do nothing: a template driver knows no faults."""
        yield from ()
