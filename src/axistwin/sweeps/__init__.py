"""Sweeps: thousands of runs of a scene with other values, what is measured in them, and what is claimed of them."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.sweeps.journal import digest, is_sweep, read
    from axistwin.sweeps.sentences import CLAIMS, MEASURES
    from axistwin.sweeps.sweep import Sweep
else:
    __getattr__ = lazy(
        __name__,
        journal="digest is_sweep read",
        sentences="CLAIMS MEASURES",
        sweep="Sweep",
    )

__all__ = ["CLAIMS", "MEASURES", "Sweep", "digest", "is_sweep", "read"]
