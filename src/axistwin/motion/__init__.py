"""Commanded motions as data: profiles, ramps, pulse trains."""

from axistwin.motion.profile import MOST_BLOCK, Profile, Segment
from axistwin.motion.ramp import Ramp
from axistwin.motion.step_queue import MOST_INTERVAL, Steps, plan
from axistwin.motion.train import HISTORY, Train

__all__ = ["HISTORY", "MOST_BLOCK", "MOST_INTERVAL", "Profile", "Ramp", "Segment", "Steps", "Train", "plan"]
