"""FMUs: the same pulses, to the nanosecond, as a scene that runs by itself, for any communication step.

    python benchmarks/fmu.py [--seed 1] [--scenes 20] [--seconds 8] [--steps 0.01 0.001 0.0001]

Each scene is exported, validated by FMPy, and run by FMPy with each step.  Every count of pulses at a communication
point, and every pulse time, is compared with the native run.  Exit code 1 if any differs.
"""

import argparse
import gc
import os
import random
import sys
import tempfile
from pathlib import Path
from shutil import rmtree
from time import process_time

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from axistwin import Bench, Scene
from axistwin.plant.servo_axis import ServoAxis
from axistwin.real.integrations.fmu.archive import export
from axistwin.real.integrations.fmu.slave import Machine
from axistwin.sweeps import Recording, Series

EXAMPLES = ("winder/scene.toml", "cut-to-length/scene.toml", "gains/scene.toml")
STEPPER = """
[[controller]]
model = "{model}"
name = "table"
host = "go.if1"
[controller.axes.X]
encoder = {{ counts_per_rev = 4000 }}
motor = {{ torque = [[0, 1.2], [4000, 0.7], [8000, 0.3]], inertia = 3e-5 }}
load = {{ torque = {torque:.3f}, inertia = {inertia:.2e} }}
[[fault]]
kind = "load"
on = "table.X"
torque = {extra:.3f}
at = {at:.6f}
duration = 0.2
[[script]]
at = {script:.6f}
do = ["input2 high", "X.load {push:.3f}"]
"""
BOARD = """
[[controller]]
model = "1811"
name = "board"
host = "go.181x"
[controller.axes.motor]
encoder = {{ counts_per_rev = 4000 }}
motor = {{ torque = [[0, 1.2], [6000, 0.5]], inertia = 3e-5 }}
load = {{ torque = {torque:.3f}, inertia = {inertia:.2e} }}
[[script]]
at = {script:.6f}
do = "motor.load {push:.3f}"
"""
MOTOR = """
[[controller]]
model = "smartmotor"
name = "knife"
program = "knife.sms"
axes.shaft = {{ motor = "frame23", load = {{ inertia_kg_m2 = {inertia:.2e} }} }}
[[script]]
at = {script:.6f}
do = "shaft.load {push:.3f}"
"""


def written(directory: Path, number: int, chance: random.Random) -> Path:
    """Write a scene with values drawn at random; return its file."""
    values = {
        "model": chance.choice(("if1", "if2")), "torque": chance.uniform(0.05, 0.5), "extra": chance.uniform(-0.3, 0.3),
        "inertia": chance.uniform(2e-5, 8e-5), "at": chance.uniform(2.5, 3.5), "script": chance.uniform(0.2, 3.5),
        "push": chance.uniform(-0.2, 0.2),
    }  # fmt: skip
    rate, way = chance.randrange(800, 6000), chance.choice(("", "-"))
    directory.mkdir()
    moves = f"go_relative {way}{rate}\ngo_relative {rate // 2}\n"
    texts = {
        "go.if1": f"X{way}{rate // 2}@{rate}S1$\nX{rate // 3}@{rate}R1$\n",
        "go.181x": f"default_velocity_and_acceleration 00 {rate} {20 * rate}\n{moves}",
        "knife.sms": f"UCI UDI ZS\nKP={rate // 20 + 20} KD=700 F\nA=300 V=400000 P={way}{rate} G TWAIT\nP=0 G\nEND\n",
        "scene.toml": (STEPPER, BOARD, MOTOR)[number % 3].format(**values),
    }
    for name, text in texts.items():
        (directory / name).write_text(text)
    return directory / "scene.toml"


def scenes(directory: Path, count: int, chance: random.Random) -> list[Path]:
    """Return the shipped examples, and generated scenes up to `count`."""
    shipped = [Path(__file__).parent.parent / "examples" / name for name in EXAMPLES][:count]
    return shipped + [written(directory / f"scene{n}", n, chance) for n in range(count - len(shipped))]


def native(scene: Path, seconds: float) -> tuple[dict[str, np.ndarray], dict[str, Series]]:
    """Return the pulse times and the positions over time of all axes of a scene that runs by itself."""
    bench = Scene.load(scene).build()
    names = list(pulse_times(bench))
    counts = {name: f"{name}.{counted(bench, name)}" for name in names}
    with Recording(bench, counts.values(), ()) as record:
        bench.run(seconds)
    return pulse_times(bench), {count: record.series(count) for count in counts.values()}


def counted(bench: Bench, name: str) -> str:
    """Return the output that has the count of an axis."""
    controller, _, axis = name.rpartition(".")
    return "position" if isinstance(bench[controller].axes[axis], ServoAxis) else "pulses"


def pulse_times(bench: Bench) -> dict[str, np.ndarray]:
    """Return the pulse times of all axes."""
    return {
        f"{controller.name}.{name}": np.asarray(axis.pulse_times())
        for controller in bench.controllers.values()
        for name, axis in controller.axes.items()
    }


class Run:
    """An FMU that FMPy has loaded."""

    def __init__(self, file: Path, name: str) -> None:
        self.name = name
        described = read_model_description(str(file))
        self.folder = extract(str(file))
        self.references = {one.name: one.valueReference for one in described.modelVariables}
        self.fmu = FMU3Slave(
            guid=described.guid, unzipDirectory=self.folder, instanceName=name,
            modelIdentifier=described.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.fmu.instantiate()
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()

    def values(self, names: list[str], seconds: float, step_s: float) -> np.ndarray:
        """Return the values of these outputs at each communication point."""
        references, found = [self.references[name] for name in names], []
        for n in range(round(seconds / step_s)):
            self.fmu.doStep(n * step_s, step_s)
            found.append(list(self.fmu.getFloat64(references)))
        return np.array(found)

    def close(self) -> None:
        """Unload the FMU."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        rmtree(self.folder, ignore_errors=True)


def differences(scene: Path, file: Path, seconds: float, step_s: float) -> tuple[int, int]:
    """Return the number of pulses of the native run, and the number of differences."""
    expected, counts = native(scene, seconds)
    run = Run(file, f"{file.stem} {step_s}")
    found = run.values(list(counts), seconds, step_s)
    points_ns = np.round(np.arange(1, len(found) + 1) * step_s * 1e9).astype(np.int64)
    wrong = sum(np.count_nonzero(one.at(points_ns) != found[:, n]) for n, one in enumerate(counts.values()))
    machines = (each for each in gc.get_objects() if isinstance(each, Machine))
    (machine,) = (each for each in machines if each.instance_name == run.name)
    inside = pulse_times(machine.bench)
    wrong += sum(not np.array_equal(times, inside[axis]) for axis, times in expected.items())
    del machine
    run.close()
    return sum(map(len, expected.values())), wrong


def main() -> int:
    """Compare all scenes with all steps; print a verdict."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--steps", type=float, nargs="+", default=[0.01, 0.001, 0.0001], metavar="SECONDS")
    given = parser.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        for number, scene in enumerate(scenes(directory, given.scenes, random.Random(given.seed))):
            file = export(scene, directory / f"machine{number}.fmu")
            problems = validate_fmu(str(file))
            begin_s = process_time()
            found = [differences(scene, file, given.seconds, step_s) for step_s in given.steps]
            wrong = sum(each for _, each in found)
            bad += bool(problems or wrong or not found[0][0])
            where = f"{scene.parent.name}: {found[0][0]:,} pulses, {wrong} differences, {len(problems)} problems"
            print(f"{where}, {process_time() - begin_s:.1f} s", flush=True)
    steps = ", ".join(f"{step_s * 1e3:g}" for step_s in given.steps)
    print(f"{'MISSED' if bad else 'met   '} {bad} of {given.scenes} scenes differ with steps of {steps} ms")
    return 1 if bad else 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)  # the library of pythonfmu3 0.3.4 may abort the normal exit: it releases its interpreter twice
