"""Drawings of machines with moving parts, as SVG and HTML, for the panel and the playground."""

from axistwin.drawings.drawing import Change, Drawing
from axistwin.drawings.figure import Figure
from axistwin.drawings.machine import asset, figure, used_axes
from axistwin.drawings.scale import Flow, grouped, minus, round_step, signed, ticks
from axistwin.drawings.switches import Press, Switches, on_slides
from axistwin.drawings.table import NO_TOOL, Table
from axistwin.drawings.trail import Trail, Trails, table_axes

__all__ = [
    "NO_TOOL",
    "Change",
    "Drawing",
    "Figure",
    "Flow",
    "Press",
    "Switches",
    "Table",
    "Trail",
    "Trails",
    "asset",
    "figure",
    "grouped",
    "minus",
    "on_slides",
    "round_step",
    "signed",
    "table_axes",
    "ticks",
    "used_axes",
]
