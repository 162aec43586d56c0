"""The machine of `axistwin ioc` and `axistwin opcua`: a scene whose controllers run inside, or a port."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from axistwin.bench import product
from axistwin.bench.options import read_options
from axistwin.cli.common.parameters import Number
from axistwin.core.errors import UsageError
from axistwin.links.pacing import read_speed
from axistwin.plant.machine_units import MachineUnits

if TYPE_CHECKING:
    from axistwin.real.integrations import Machine

F = TypeVar("F", bound=Callable[..., Any])
_OPTIONS = [
    click.option("--units", multiple=True, metavar="AXIS=…", help='Unit of an axis, e.g. "X=400 per mm"; in a scene '
                 '"if1.X=400 per mm". Default: the units of the scene, or counts.'),
    click.option("--registers", default="", metavar="NAME,…", help="Registers to serve: variables and reports of a "
                 "SmartMotor, e.g. a,RTEMP, or encoder of an 1811; in a scene motor.a."),
    click.option("--option", "options", multiple=True, metavar="NAME=VALUE",
                 help="An option of the driver, e.g. home_input=1; in a scene if1.home_input=1."),
    click.option("--baud", type=click.IntRange(50, 1_000_000), metavar="RATE", help="Baud rate at a PORT."),
    click.option("--rate", type=Number(min=0.1, max=100), default=10, show_default=True, metavar="HZ",
                 help="Readings of each axis per second."),
    click.option("--speed", default="1", show_default=True, metavar="N|max", help="Virtual time of a scene per real "
                 "time; max: as fast as possible."),
]  # fmt: skip


def options(command: F) -> F:
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class Wanted:
    """Options that the user has given to `axistwin ioc` or `axistwin opcua`."""

    what: str
    model: str | None
    units: Mapping[str, MachineUnits]
    registers: tuple[str, ...]
    options: Mapping[str, Any]
    baud: int | None
    rate: float
    speed: float | None

    @classmethod
    def read(cls, what: str, model: str | None, given: Mapping[str, Any]) -> "Wanted":
        """Return the checked command line options.  Raises UsageError for an invalid option."""
        is_scene = what.endswith(".toml")
        if is_scene and (model or given["baud"]):
            raise UsageError(
                "--model and --baud cannot be used with a scene file: remove these options, "
                "or give a PORT instead of the scene file"
            )
        if not is_scene and model is None:
            raise UsageError("the model of the controller at the port is missing: add --model, e.g. --model if1")
        if not is_scene and given["speed"] != "1":
            raise UsageError(
                "--speed cannot be used with a PORT: remove --speed, or give a scene file instead of the PORT"
            )
        if model is not None:
            product(model)
        return cls(
            what, model, dict(_unit(text) for text in given["units"]),
            tuple(name.strip() for name in given["registers"].split(",") if name.strip()),
            read_options(given["options"]), given["baud"], given["rate"], read_speed(given["speed"]),
        )  # fmt: skip

    async def machine(self) -> "Machine":
        # Import the drivers only when needed, because the drivers load slowly.
        from axistwin.real.integrations import at_port, of_scene

        period_s = 1 / self.rate
        if self.model is not None:
            return at_port(
                self.what, self.model, self.options, baud=self.baud, units=self.units, registers=self.registers,
                period_s=period_s,
            )  # fmt: skip
        # Import `Scene` only for a scene file, because the import is slow.
        from axistwin.scenes.scene import Scene

        scene = Scene.load(Path(self.what))
        if set(scene.models) <= {*scene.hosted, *(f"{name}.rs485" for name in scene.hosted)}:
            raise UsageError(
                f"every controller of {self.what} has a host in the scene: "
                "leave out the key `host` of those whose axes are to be served"
            )
        for name, found in self.options.items():
            if not isinstance(found, dict):
                own = next((each for each in scene.models if each not in scene.hosted), "if1")
                raise UsageError(
                    f"--option {name} does not begin with the name of a controller: "
                    f"expected e.g. --option {own}.{name}={found}"
                )
        return await of_scene(
            scene.build(served=True), self.options, speed=self.speed, without=frozenset(scene.hosted),
            units=self.units, registers=self.registers, period_s=period_s,
        )  # fmt: skip


def _unit(text: str) -> tuple[str, MachineUnits]:
    axis, equals, unit = text.partition("=")
    if not equals:
        raise UsageError(f'invalid units {text!r}: expected AXIS=COUNTS per UNIT, e.g. "X=400 per mm"')
    return axis.strip(), MachineUnits.written(unit.strip())
