"""Commanded motions as data: profiles, ramps, pulse trains."""

from axistwin.motion.profile import Profile, Segment

__all__ = ["Profile", "Segment"]
