"""The real machine: integrations, the probe and the stand-in."""
