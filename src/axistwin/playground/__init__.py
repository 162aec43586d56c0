"""The playground: axistwin in a web page, executed by Pyodide in the browser, without a server."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.playground.building import build
    from axistwin.playground.link import LONGEST_LINK, Shared, decode, encode
    from axistwin.playground.machine import Playground
else:
    __getattr__ = lazy(
        __name__,
        building="build",
        link="LONGEST_LINK Shared decode encode",
        machine="Playground",
    )

__all__ = ["LONGEST_LINK", "Playground", "Shared", "build", "decode", "encode"]
