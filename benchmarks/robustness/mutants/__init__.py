"""Mutation testing: changes in the source of a family that its tests must detect."""
