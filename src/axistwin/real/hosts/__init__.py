"""The host's end of a port, real or virtual, in real or in virtual time."""
