"""Commanded motions as data: profiles, ramps, pulse trains."""
