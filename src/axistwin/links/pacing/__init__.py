"""Pacing: virtual time follows the wall clock, or runs as fast as possible."""

from axistwin.links.pacing.pacer import Pacer
from axistwin.links.pacing.real_time import BLOCK_S
from axistwin.links.pacing.slices import SLICE_S
from axistwin.links.pacing.speeds import read_speed

__all__ = ["BLOCK_S", "SLICE_S", "Pacer", "read_speed"]
