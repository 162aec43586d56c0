"""The command line: one module per command, in a folder per task; `main.py` has the table of commands."""
