"""Stand-in for a broken controller: an emulated controller drives real motors through a motion board.

The motion board runs Klipper's micro-controller firmware.  This package implements the firmware's documented protocol.
"""
