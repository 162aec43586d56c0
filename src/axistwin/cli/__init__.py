"""The command line: one module per command, in a folder per task; `program.py` has the table of commands.

The commands import large modules inside functions, so that the program `axistwin` starts fast.
"""
