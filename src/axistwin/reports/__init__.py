"""Texts about a run for people: what was said and what moved."""
