"""Parts of an 1810 or 1811: state and primitives that the chapters use; no part depends on the board."""
