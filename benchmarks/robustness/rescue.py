"""Rescue of virtual controllers: all line formats, random states, twins of twins, and a full program.

    python benchmarks/robustness/rescue.py [--seed 1] [--states 200] [--twins 20] [--no-formats] [--no-program]

Formats: a controller with an incomplete move from another host is found at each baud rate and frame, and no pulse is
made.  States: after random commands, reading makes no pulse.  Twins: the files of a rescue of a twin are those of the
twin's own scene.  Program: 32 kB at 9600 baud are read in 60 s plus the time of the characters, in virtual time.  The
exit code is 1 if one of them fails.
"""

import argparse
import random
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench, Scene
from axistwin.bench.programs import stored_programs
from axistwin.controllers.digiplan.chapters.data_format import BAUD_RATES as INTERFACE_RATES
from axistwin.controllers.smartmotor.serial.serial_data import BAUD_RATES as MOTOR_RATES
from axistwin.core.errors import AxistwinError
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.rescue.finding import find
from axistwin.real.probing.rescue.saving import Rescue, rescue
from axistwin.sim.frames import UartFormat
from states import random_state

MODELS = ("if1", "1811", "smartmotor")
INTERFACE_FORMATS = [f"{u}{x1}{x2}" for u in "UV" for x1 in (1, 2, 5, 6) for x2 in (1, 2, 3, 4, 5, 6)]
PARITIES = {"1": "N", "2": "N", "3": "O", "4": "E", "5": "O", "6": "E"}
FULL, LIMIT_S = 32_768, 60.0
BITS = 10
"""Bits of a character in 9600 8N1."""


def new(model: str, **options: Any) -> tuple[Bench, VirtualEnd]:
    """Return a controller that has just been switched on."""
    bench = Bench()
    controller = bench.add(model, **options)
    return bench, VirtualEnd(bench, controller)


def interface(baud: int, message: str) -> tuple[Bench, VirtualEnd]:
    """Return an IF1 with this data format, and with a move that its host has not ended."""
    bench, end = new("if1")
    bench.run(1.5)
    end.set_line(UartFormat(baud, 8, "N", 2))
    end.controller.serial.write(b"(")
    bench.run(1.5)
    end.controller.serial.write(message.encode() + (b"\r" if message[0] == "U" else b"\n"))
    bench.run(2.5)
    bits, stop = (7 if message[1] in "12" else 8), (1 if message[1] in "15" else 2)
    end.set_line(UartFormat(baud, bits, PARITIES[message[2]], stop))  # type: ignore[arg-type]
    end.controller.serial.write(b"X+1000$")
    bench.run(1.5)
    return bench, end


def motor(baud: int, frame: str, incomplete: bytes = b"G") -> tuple[Bench, VirtualEnd]:
    """Return a SmartMotor with this line format, and with a move that its host has not ended."""
    bench, end = new("smartmotor")
    bench.run(0.1)
    end.controller.serial.write(
        f"UCI UDI ZS A=1000 V=100000 P=5000 OCHN(RS2,0,{frame[1]},{baud},1,{frame[0]},C)\r".encode()
    )
    bench.run(0.3)
    end.set_line(UartFormat(baud, int(frame[0]), frame[1], 1))  # type: ignore[arg-type]
    end.controller.serial.write(incomplete)
    bench.run(0.1)
    return bench, end


def formats() -> Iterator[str]:
    """Find controllers at each line format; yield the names of controllers that are not found, or that move."""
    cases = [("IF1", baud, message, interface) for baud in INTERFACE_RATES for message in INTERFACE_FORMATS]
    cases += [("SmartMotor", baud, frame, motor) for baud in MOTOR_RATES for frame in ("8N",)]
    for name, baud, frame, make in cases:
        _, end = make(baud, frame)
        before = {n: r.read() for n, r in end.controller.registers.items() if n in ("A", "V", "P", "RA", "RD", "KP")}
        try:
            found = find(end)
        except AxistwinError as error:
            yield f"{name} {baud} {frame}: {error}"
            continue
        axes = end.controller.axes.values()
        after = {n: end.controller.registers[n].read() for n in before}
        if any(axis.moving or axis.position for axis in axes) or before != after:
            yield f"{name} {baud} {frame}: moved, or a setting changed, at {found.line}: {before} {after}"
        elif found.line is None or found.line.baudrate != baud:
            yield f"{name} {baud} {frame}: found as {found}"


def still(model: str, rng: random.Random, out: Path) -> str:
    """Rescue a controller in a random state; return an error, or an empty text."""
    bench, end, said = random_state(model, rng)
    if bench is None:
        return ""
    began = bench.now
    before = {name: axis.position for name, axis in end.controller.axes.items()}
    with suppress(AxistwinError):
        rescue(end, find(end, model), out)
    pulses = model != "smartmotor" and sum(axis.pulse_times(began).size for axis in end.controller.axes.values())
    moved = before != {name: axis.position for name, axis in end.controller.axes.items()}
    return f"{model}: {pulses} pulses after {said}" if pulses or moved else ""


def twins(model: str, rng: random.Random, out: Path) -> str:
    """Rescue a controller, its twin and the twin of its twin; return an error, or an empty text."""
    bench, end, said = random_state(model, rng)
    if bench is None:
        return ""
    try:
        first = rescue(end, find(end, model), out / "first")
    except AxistwinError:
        return ""
    second = again(model, out / "first", out / "second")
    third = again(model, out / "second", out / "third")
    if first.differences:
        return f"{model}: the twin differs in {first.differences} after {said}"
    if scene_of(first) != scene_of(second):
        return f"{model}: the scene of the twin's rescue differs after {said}"
    return (
        "" if second.files == third.files else f"{model}: the files of the second and third rescue differ after {said}"
    )


def scene_of(made: Rescue) -> dict[str, str]:
    """Return the scene without comments, and the files that it names."""
    texts = {name: text for name, text in made.files.items() if name not in ("exchange.talk", "rescue.json")}
    lines = texts["machine.toml"].splitlines()
    return texts | {"machine.toml": "\n".join(line for line in lines if not line.startswith("#"))}


def again(model: str, directory: Path, out: Path) -> Any:
    """Start the scene in the directory and rescue its controller."""
    bench = Scene.load(directory / "machine.toml").build()
    (controller,) = bench.controllers.values()
    end = VirtualEnd(bench, controller)
    if controller.product.family == "digiplan":
        bench.run(1.5)
        controller.serial.write(b"(")
        bench.run(1.5)
        controller.serial.write(b"U61\r")
    bench.run(0.0 if model == "smartmotor" else 3.0)
    return rescue(end, find(end, model), out)


def program() -> tuple[float, bool]:
    """Rescue a program of 32 kB; return the time without that of its characters, and if the text is the same."""
    bench, end = new("smartmotor")
    lines = "".join(f"C{n % 900} a=a+{n} IF a>{n * 7} b=b-1 ENDIF\n" for n in range(2000))
    text = lines[: lines.rindex("\n", 0, FULL - 4) + 1] + "END\n"
    stored_programs.store(text.encode(), "full.sms", end.controller)
    bench.run(0.1)
    with TemporaryDirectory() as scratch:
        began = bench.seconds
        end.controller.serial.write(b"END\r")
        done = rescue(end, find(end, "smartmotor"), Path(scratch) / "out")
        return bench.seconds - began - len(text) * BITS / 9600, done.contents.program == text and not done.differences


def main() -> int:
    """Run all campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name, default in (("seed", 1), ("states", 200), ("twins", 20)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--no-formats", action="store_true")
    parser.add_argument("--no-program", action="store_true")
    given = parser.parse_args()
    rng = random.Random(given.seed)
    wrong = [] if given.no_formats else list(formats())
    for number in range(given.states + given.twins):
        campaign = still if number < given.states else twins
        with TemporaryDirectory() as scratch:
            if line := campaign(MODELS[number % len(MODELS)], rng, Path(scratch) / "out"):
                wrong.append(line)
    seconds, same = (0.0, True) if given.no_program else program()
    print("\n".join(wrong), end="\n" if wrong else "")
    good = not wrong and same and seconds <= LIMIT_S
    print(
        f"{'held' if good else 'FAILED'}: {len(wrong)} errors in formats, {given.states} states, {given.twins} twins; "
        f"32 kB in {seconds:.1f} s plus the time of the characters; seed {given.seed}"
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
