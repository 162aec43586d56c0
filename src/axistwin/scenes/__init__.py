"""Scenes: a bench from a TOML file."""
