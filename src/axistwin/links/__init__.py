"""Real ports for the controllers of a bench.  Only this package uses asyncio and the wall clock."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.links.pacing import Pacer
    from axistwin.links.server import Server
    from axistwin.links.urls import PortUrl, parse
else:
    __getattr__ = lazy(__name__, pacing="Pacer", server="Server", urls="PortUrl parse")

__all__ = ["Pacer", "PortUrl", "Server", "parse"]
