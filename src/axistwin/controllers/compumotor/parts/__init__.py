"""Parts of an 1810 or 1811, such as the pulse generator and the stream; they do not depend on the board."""
