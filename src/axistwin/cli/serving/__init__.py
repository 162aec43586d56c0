"""Commands that connect hosts and controllers: real ports, recordings, a terminal."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.cli.serving.ending import fail
    from axistwin.cli.serving.host_lines import lines
    from axistwin.cli.serving.served import scene
    from axistwin.cli.serving.sparing import IN_FULL, Sparing
else:
    __getattr__ = lazy(
        __name__,
        ending="fail",
        host_lines="lines",
        served="scene",
        sparing="IN_FULL Sparing",
    )

__all__ = ["IN_FULL", "Sparing", "fail", "lines", "scene"]
