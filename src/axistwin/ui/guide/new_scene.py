"""Generate a new scene from the user's answers: the scene file, and a first program for each controller."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count

from axistwin.bench import FAMILIES
from axistwin.core.errors import UsageError
from axistwin.links.urls import PortUrl, parse

DIGIPLAN_AXES = "XYZ"
SUFFIXES = {"digiplan": ".if1", "compumotor": ".181x", "smartmotor": ".sms"}
LEAST_TRAVEL, MOST_TRAVEL = 100, 100_000_000
INSIDE, OUTSIDE, BOTH = HOSTS = ("scene", "outside", "both")
"""Choices for the host: simulated by the scene, an external program at a port, or both."""
BUS_PORT = 1811
FIRST = {"digiplan": "127.0.0.1:5001", "smartmotor": "127.0.0.1:5001", "compumotor": f"127.0.0.1:{BUS_PORT}"}


@dataclass(frozen=True)
class Answers:
    """The user's answers to the questions of `axistwin new`."""

    models: tuple[str, ...]
    axes: int  # Number of axes of each IF1 and IF2; other models have one axis.
    travel: int  # Place of the plus limit switch, in motor pulses or encoder counts; the minus limit switch is at -100.
    host: str
    port: PortUrl  # Port of the first serial controller; the ports of further controllers have the next numbers.


def read_models(text: str) -> tuple[str, ...]:
    """Parse a list of models such as `if1, smartmotor`.  Raises UsageError for an unknown model."""
    models = tuple(word.lower() for word in text.replace(",", " ").split())
    known_models = ", ".join(FAMILIES)
    if unknown_model := next((model for model in models if model not in FAMILIES), ""):
        raise UsageError(f"no model {unknown_model!r}: expected one or more of {known_models}")
    if not models:
        raise UsageError(f"no model is given: expected one or more of {known_models}")
    return models


def read_port(text: str) -> PortUrl:
    """Parse the URL of a TCP port, e.g. `tcp://127.0.0.1:5001`.  Raises UsageError for another kind of port."""
    port = parse(text)
    if port.scheme not in ("tcp", "rfc2217"):
        raise UsageError(
            f"invalid port {text!r} of the first controller: expected a tcp or rfc2217 port, e.g. tcp://127.0.0.1:5001"
        )
    return port


def files(answers: Answers) -> dict[str, str]:
    """Return the contents of the new scene file and of its program files, by file name."""
    names = _names(answers.models)
    programs = {} if answers.host == OUTSIDE else dict(_programs(answers, names))
    return {"scene.toml": "\n".join(_scene(answers, names, list(programs))) + "\n", **programs}


def _names(models: Sequence[str]) -> list[str]:
    several, seen = Counter(models), Counter[str]()
    names = []
    for model in models:
        seen[model] += 1
        names.append(model if several[model] == 1 else f"{model}_{seen[model]}")
    return names


def _scene(answers: Answers, names: Sequence[str], programs: Sequence[str]) -> Iterator[str]:
    yield "# A new scene.  All keys are described by `axistwin docs scenes`.\n#"
    if answers.host != OUTSIDE:
        yield "#     axistwin run scene.toml                   the programs below, at full speed"
    if answers.host != INSIDE:
        yield "#     axistwin serve scene.toml                 the ports below, for your own host program"
    yield "#     axistwin serve scene.toml --panel 8080    the bench in a browser, http://127.0.0.1:8080/"
    yield '#     axistwin check scene.toml                 errors in this file\n\ntitle = "A new scene"'
    ports = _ports(answers)
    for index, (model, name) in enumerate(zip(answers.models, names, strict=True)):
        yield from ("", "[[controller]]", f'model = "{model}"', f'name = "{name}"')
        if programs:
            yield _program_line(FAMILIES[model], programs[index])
        if answers.host != INSIDE:
            yield f'ports = ["{ports[index]}"]'
        yield from _axes(answers, model)


def _program_line(family: str, program: str) -> str:
    if family == "smartmotor":
        return f'program = "{program}"               # stored in the motor; it starts at power-up'
    return f'host = "{program}"                  # a simulated host sends these lines'


def _ports(answers: Answers) -> list[PortUrl]:
    serial, bus = count(answers.port.port), count(BUS_PORT)
    found = []
    for model in answers.models:
        if FAMILIES[model] == "compumotor":
            found.append(PortUrl("bus", answers.port.host, next(bus) if answers.port.port else 0))
        else:
            found.append(replace(answers.port, port=next(serial) if answers.port.port else 0))
    return found


def _axes(answers: Answers, model: str) -> Iterator[str]:
    family = FAMILIES[model]
    axes = {"digiplan": DIGIPLAN_AXES[: answers.axes], "compumotor": ("motor",), "smartmotor": ("shaft",)}[family]
    unit = "encoder counts" if family == "smartmotor" else "motor pulses"
    for axis in axes:
        yield from ("", f"[controller.axes.{axis}]")
        yield f"limits = [-100, {answers.travel}]    # in {unit}: a limit switch opens beyond each"
        yield '# units = { per = 80, of = "mm" }    # then limits = ["-1 mm", "250 mm"], and pictures in mm'
        if family == "smartmotor":
            yield 'motor = "frame23"          # a data sheet: frame17, frame23, frame34; without it the motor is ideal'
    if family != "smartmotor":
        yield "# motor = { torque = [[0, 1.2], [5000, 0.4]], inertia = 3e-5 }    # pulses/s, N·m: the motor can stall"


def _programs(answers: Answers, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    distance = min(answers.travel // 2, 4000)
    for model, name in zip(answers.models, names, strict=True):
        family = FAMILIES[model]
        moves = "\n".join(f"{axis}{distance}@1000$\n{axis}-{distance}$" for axis in DIGIPLAN_AXES[: answers.axes])
        yield f"{name}{SUFFIXES[family]}", PROGRAMS[family].format(distance=distance, moves=moves)


PROGRAMS = {
    "digiplan": """\
; Each axis moves there and back.  The initialisation is done first.
{moves}
K                       ; the faults: 0 if there are none
""",
    "compumotor": """\
; The motor moves there and back.
default_velocity_and_acceleration 00 5000 50000
go_relative {distance}
go_relative -{distance}
position_from_absolute_zero
""",
    "smartmotor": """\
' The motor moves there and back, within its limit switches.
ZS
MP A=800 V=400000
P={distance} G TWAIT
PRINT("there ",@P,#13)
WAIT=800                ' samples
P=0 G TWAIT
PRINT("home ",@P,#13)
END
""",
}
"""The first program of a controller, by family."""
