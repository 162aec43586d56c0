"""The oscilloscope without its user interface: recording, view, measurement and files."""

from axistwin.panel.scope.cursors import between, duration, nearest_edge, next_edge, rate, value_at
from axistwin.panel.scope.decimation import line, marks, window
from axistwin.panel.scope.frames import FULL, TOP, frame
from axistwin.panel.scope.meaning import used
from axistwin.panel.scope.recorder import MOST_SIGNALS, Recorder
from axistwin.panel.scope.saving import saved
from axistwin.panel.scope.screen import Screen, first_choice, searched
from axistwin.panel.scope.tracks import MOST_BYTES, Track, Words
from axistwin.panel.scope.triggers import AUTO, DOWN, EITHER, NORMAL, SINGLE, UP, Trigger

__all__ = [
    "AUTO", "DOWN", "EITHER", "FULL", "MOST_BYTES", "MOST_SIGNALS", "NORMAL", "SINGLE", "TOP", "UP", "Recorder",
    "Screen", "Track", "Trigger", "Words", "between", "duration", "first_choice", "frame", "line", "marks",
    "nearest_edge", "next_edge", "rate", "saved", "searched", "used", "value_at", "window",
]  # fmt: skip
