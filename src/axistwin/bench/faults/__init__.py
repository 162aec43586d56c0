"""Fault injection: the kinds of faults, their places, and their begin and end in virtual time."""
