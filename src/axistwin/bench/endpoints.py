"""Whom a host can talk to on a bench, by name: controllers, their second channels, and lines that motors share."""

from axistwin.bench.actions import on_a_bus
from axistwin.bench.bench import Bench
from axistwin.bench.codec import CHARACTERS, Codec, codec_of


def names(bench: Bench) -> list[str]:
    """All of them: `if1`, `motor`, `motor.rs485` (once somebody has it), `chain`."""
    boards = [name for name, controller in bench.controllers.items() if on_a_bus(controller)]
    own = [name for name in bench.ports if name not in bench.lines]
    in_order = [name for name in bench.controllers if name in (*boards, *own)]
    return [*in_order, *(name for name in own if name not in in_order), *bench.lines]


def at_a_bus(bench: Bench, name: str) -> bool:
    """Whether what is said there are whole commands and messages, through the registers of a board."""
    return name in bench.controllers and on_a_bus(bench[name])


def codec_at(bench: Bench, name: str) -> Codec:
    """How what is said there is written."""
    return codec_of(bench[name].product) if name in bench.controllers else CHARACTERS


def several(bench: Bench) -> bool:
    """Whether one has to say whom one means."""
    return len(names(bench)) > 1 or len(bench.controllers) > 1
