"""Programs: command lines, hex commands and stored programs, and running them on a bench."""
