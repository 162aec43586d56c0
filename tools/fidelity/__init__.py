"""The fidelity report: what the manuals say, what axistwin does, and the evidence for each row."""
