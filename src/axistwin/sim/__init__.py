"""Ring 1: time and signals.  No wall clock, no threads, no sockets, no sleeping."""
