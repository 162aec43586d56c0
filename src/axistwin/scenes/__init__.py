"""Scenes: build a bench from a TOML file."""
