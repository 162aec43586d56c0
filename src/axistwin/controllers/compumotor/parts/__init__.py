"""Parts of an 1810 or 1811: state and primitives for the chapters, which do not depend on the board."""
