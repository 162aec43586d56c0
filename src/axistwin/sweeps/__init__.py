"""Sweeps: run a scene many times with varied values, measure each run, and check claims about each run."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.sweeps.journal import digest, is_sweep, read
    from axistwin.sweeps.sentences import CLAIMS, MEASURES
    from axistwin.sweeps.sweep import Sweep
    from axistwin.sweeps.tuning import Tuning
else:
    __getattr__ = lazy(
        __name__,
        journal="digest is_sweep read",
        sentences="CLAIMS MEASURES",
        sweep="Sweep",
        tuning="Tuning",
    )

__all__ = ["CLAIMS", "MEASURES", "Sweep", "Tuning", "digest", "is_sweep", "read"]
