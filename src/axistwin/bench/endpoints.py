"""Endpoints of a bench that a host can connect to, by name: controllers, their second channels, and shared lines."""

from typing import TYPE_CHECKING

from axistwin.bench.bench import Bench
from axistwin.bench.controller import on_a_bus

if TYPE_CHECKING:
    from axistwin.bench.codec import Codec


def names(bench: Bench) -> list[str]:
    boards = [name for name, controller in bench.controllers.items() if on_a_bus(controller)]
    own = [name for name in bench.ports if name not in bench.lines]
    in_order = [name for name in bench.controllers if name in (*boards, *own)]
    return [*in_order, *(name for name in own if name not in in_order), *bench.lines]


def at_a_bus(bench: Bench, name: str) -> bool:
    """True if the endpoint is a board on a bus.  A bus transfers whole commands and messages instead of characters."""
    return name in bench.controllers and on_a_bus(bench[name])


def codec_at(bench: Bench, name: str) -> "Codec":
    from axistwin.bench.codec import CHARACTERS, codec_of

    return codec_of(bench[name].product) if name in bench.controllers else CHARACTERS


def several(bench: Bench) -> bool:
    """True if the bench has several endpoints.  Each line of a conversation must then name its endpoint."""
    return len(names(bench)) > 1 or len(bench.controllers) > 1
