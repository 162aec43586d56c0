"""Traces: what has changed on a bench, written while it happens, read again and compared."""
