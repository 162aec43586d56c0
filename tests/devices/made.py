"""Devices for tests of the room: a class, a bench, and what a host says to it."""

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.devices import Device
from axistwin.devices.making import product_of


def on_a_bench(kind: type[Device], **options: Any) -> tuple[Bench, Controller]:
    """Return a bench and a controller of a class, a second after power-on; characters take no time."""
    bench = Bench()
    controller = bench.add(product_of(kind), line="instant", **options)
    bench.run(1)
    return bench, controller


def ask(bench: Bench, controller: Controller, line: bytes, seconds: float = 0.01) -> bytes:
    """Return what a host receives within `seconds` after a line."""
    controller.serial.write(line)
    bench.run(seconds)
    return controller.serial.read()


def device(controller: Controller) -> Any:
    """Return the object that exists while the power is on."""
    return controller._device.device


def example(name: str, kind: str) -> Any:
    """Return a class from `examples/devices`."""
    return device_in(Path(__file__).parents[2] / "examples" / "devices" / f"{name}.py", kind)


def device_in(file: Path, kind: str) -> Any:
    """Return a class from a file."""
    module = f"device_in_{file.stem}"
    if module not in sys.modules:
        made = sys.modules[module] = ModuleType(module)
        made.__file__ = str(file)
        exec(compile(file.read_text(encoding="utf-8"), file, "exec"), vars(made))  # and leave no files there
    return getattr(sys.modules[module], kind)


def client(module: str) -> Any:
    """Return a module of somebody else's host program, or skip the test."""
    package = module.partition(".")[0].replace("_", "-")
    listed = package in Path(__file__).with_name("clients.txt").read_text(encoding="utf-8")
    what = "--no-deps -r tests/devices/clients.txt" if listed else package
    return pytest.importorskip(module, reason=f"no {package}: pip install {what}", exc_type=ImportError)
