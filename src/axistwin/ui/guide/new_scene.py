"""Generate a new scene from the user's answers: the scene file, and a first program for each controller."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count

from axistwin.bench import is_model, product
from axistwin.bench.models import models
from axistwin.core.errors import UsageError
from axistwin.links.urls import PortUrl, parse
from axistwin.plant.axes import servo_axis

DIGIPLAN_AXES = "XYZ"
STORED, TALK = ".sms", ".talk"
LEAST_TRAVEL, MOST_TRAVEL = 100, 100_000_000
INSIDE, OUTSIDE, BOTH = HOSTS = ("scene", "outside", "both")
"""Choices for the host: simulated by the scene, an external program at a port, or both."""
BUS_PORT = 1811


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
    found = tuple(word.lower() for word in text.replace(",", " ").split())
    if unknown_model := next((model for model in found if not is_model(model)), ""):
        raise UsageError(f"no model {unknown_model!r}: expected one or more of {', '.join(models())}")
    if not found:
        raise UsageError(f"no model is given: expected one or more of {', '.join(models())}")
    return found


def read_port(text: str) -> PortUrl:
    """Parse the URL of a TCP port, e.g. `tcp://127.0.0.1:5001`.  Raises UsageError for another kind of port."""
    port = parse(text)
    if port.scheme not in ("tcp", "rfc2217"):
        raise UsageError(
            f"invalid port {text!r} of the first controller: expected a tcp or rfc2217 port, e.g. tcp://127.0.0.1:5001"
        )
    return port


def files(answers: Answers, program: str = "axistwin") -> dict[str, str]:
    """Return the contents of the new scene file and of its program files, by file name."""
    names = _names(answers.models)
    programs = {} if answers.host == OUTSIDE else dict(_programs(answers, names))
    return {"scene.toml": "\n".join(_scene(answers, names, list(programs), program)) + "\n", **programs}


def _names(models: Sequence[str]) -> list[str]:
    several, seen = Counter(models), Counter[str]()
    names = []
    for model in models:
        seen[model] += 1
        names.append(model if several[model] == 1 else f"{model}_{seen[model]}")
    return names


def _scene(answers: Answers, names: Sequence[str], programs: Sequence[str], program: str) -> Iterator[str]:
    yield "# A new scene.  All keys are described by `axistwin docs scenes`.\n#"
    if answers.host != OUTSIDE:
        yield f"#     {program} run scene.toml                   the programs below, at full speed"
    if answers.host != INSIDE:
        yield f"#     {program} serve scene.toml                 the ports below, for your own host program"
    yield f"#     {program} serve scene.toml --panel 8080    the bench in a browser, http://127.0.0.1:8080/"
    yield f'#     {program} check scene.toml                 errors in this file\n\ntitle = "A new scene"'
    ports = _ports(answers)
    for index, (model, name) in enumerate(zip(answers.models, names, strict=True)):
        yield from ("", "[[controller]]", f'model = "{model}"', f'name = "{name}"')
        if programs:
            yield _program_line(programs[index])
        if answers.host != INSIDE:
            yield f'ports = ["{ports[index]}"]'
        yield from _axes(answers, model)


def _program_line(program: str) -> str:
    if program.endswith(STORED):
        return f'program = "{program}"               # stored in the motor; it starts at power-up'
    return f'host = "{program}"                  # a simulated host sends these lines'


def _ports(answers: Answers) -> list[PortUrl]:
    serial, bus = count(answers.port.port), count(BUS_PORT)
    found = []
    for model in answers.models:
        if product(model).line is None:
            found.append(PortUrl("bus", answers.port.host, next(bus) if answers.port.port else 0))
        else:
            found.append(replace(answers.port, port=next(serial) if answers.port.port else 0))
    return found


def _axes(answers: Answers, model: str) -> Iterator[str]:
    made = product(model)
    servo = made.make_axis is servo_axis
    unit = "encoder counts" if servo else "motor pulses"
    for axis in made.axes[: answers.axes]:
        yield from ("", f"[controller.axes.{axis}]")
        yield f"limits = [-100, {answers.travel}]    # in {unit}: a limit switch opens beyond each"
        yield '# units = { per = 80, of = "mm" }    # then limits = ["-1 mm", "250 mm"], and pictures in mm'
        if servo:
            yield 'motor = "frame23"          # a data sheet: frame17, frame23, frame34; without it the motor is ideal'
    if not servo:
        yield "# motor = { torque = [[0, 1.2], [5000, 0.4]], inertia = 3e-5 }    # pulses/s, N·m: the motor can stall"


def _programs(answers: Answers, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    distance = min(answers.travel // 2, 4000)
    for model, name in zip(answers.models, names, strict=True):
        made = product(model)
        moves = "\n".join(f"{axis}{distance}@1000$\n{axis}-{distance}$" for axis in DIGIPLAN_AXES[: answers.axes])
        text = PROGRAMS.get(made.family, PLAIN)
        yield f"{name}{made.suffix or TALK}", text.format(model=model, distance=distance, moves=moves)


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
PLAIN = """\
; model: {model}
; Lines of the host begin with >, e.g. > 1PA1000\\r; `axistwin commands {model}` lists its commands.
"""
"""The first conversation of a controller that is not ours."""
