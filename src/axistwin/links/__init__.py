"""Real ports for the controllers of a bench.  The ports use asyncio; pacing uses the wall clock."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.links.manual_pacer import ManualPacer
    from axistwin.links.pacing import Pacer, read_speed
    from axistwin.links.server import Server
    from axistwin.links.urls import PortUrl, parse, parse_as
else:
    __getattr__ = lazy(
        __name__, manual_pacer="ManualPacer", pacing="Pacer read_speed", server="Server", urls="PortUrl parse parse_as"
    )

__all__ = ["ManualPacer", "Pacer", "PortUrl", "Server", "parse", "parse_as", "read_speed"]
