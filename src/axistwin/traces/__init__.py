"""Traces: record the changes on a bench in a file during a run; read traces back; compare them."""
