"""Virtual time, pins and lines.  This package uses no wall clock, no threads and no sockets."""
