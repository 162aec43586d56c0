"""Drawings of machines with moving parts, and listings with marked lines.

A drawing is sent to the browser once.  After that, one message per frame contains the changes.
"""
