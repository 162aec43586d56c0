"""Devices for tests of the room: a class, a bench, and what a host says to it."""

from typing import Any

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
