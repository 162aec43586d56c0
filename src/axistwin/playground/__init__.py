"""The playground: axistwin in a web page, executed by Pyodide in the browser, without a server."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.playground.building import build
    from axistwin.playground.machine import Playground
else:
    __getattr__ = lazy(__name__, building="build", machine="Playground")

__all__ = ["Playground", "build"]
