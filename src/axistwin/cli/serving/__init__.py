"""Commands that connect hosts and controllers: real ports, recordings, a terminal."""
