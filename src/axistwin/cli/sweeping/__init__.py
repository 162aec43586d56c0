"""Commands that run a scene many times."""
