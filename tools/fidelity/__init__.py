"""The fidelity report: statements of the manuals, behaviour of axistwin, and the evidence for each row."""
