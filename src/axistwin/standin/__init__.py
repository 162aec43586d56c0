"""A stand-in for a board that has died: the controllers' pulses go to real motors, through a motion board.

The board runs Klipper's micro-controller firmware.  This package speaks the firmware's documented protocol.
"""
