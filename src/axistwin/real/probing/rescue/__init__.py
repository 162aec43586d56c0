"""Read the contents of a controller without motion, and start a twin with the same contents."""
