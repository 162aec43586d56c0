"""PC-BASIC on a pseudo terminal: `python tied_lines.py OPTIONS`.

A pseudo terminal has no control lines, and PC-BASIC cannot open a device without.  Here they are on, as with a cable of
three wires whose plug joins them.
"""

import sys

import serial
from pcbasic import main

for line in ("cts", "dsr", "cd", "ri"):
    setattr(serial.Serial, line, property(lambda self: True))
for update in ("_update_rts_state", "_update_dtr_state"):
    setattr(serial.Serial, update, lambda self: None)
main(*sys.argv[1:])
