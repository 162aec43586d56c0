"""Output to LinuxCNC HAL: the component `axistwin` passes positions on to stepgen, a servo loop or a fieldbus drive."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.standin.hal.board import HalBoard
    from axistwin.standin.hal.component import PERIOD_S, Motion
    from axistwin.standin.hal.sender import PYTHON, HalSender
    from axistwin.standin.hal.track import SLOW_S, Track
    from axistwin.standin.hal.wiring import HalWiring
else:
    __getattr__ = lazy(
        __name__,
        board="HalBoard",
        component="Motion PERIOD_S",
        sender="HalSender PYTHON",
        track="SLOW_S Track",
        wiring="HalWiring",
    )

__all__ = ["PERIOD_S", "PYTHON", "SLOW_S", "HalBoard", "HalSender", "HalWiring", "Motion", "Track"]
