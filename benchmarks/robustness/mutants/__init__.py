"""Mutation testing: change one thing in the source of a family, and see whether its tests notice."""
