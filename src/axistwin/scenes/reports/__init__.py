"""Reports of a run: its messages, moves and refused lines, as text and as JSON."""
