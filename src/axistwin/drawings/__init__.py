"""Drawings of machines with moving parts, as SVG and HTML, for the panel and the playground."""

from axistwin.drawings.drawing import Change, Drawing
from axistwin.drawings.figure import Figure
from axistwin.drawings.machine import asset, figure, used_axes
from axistwin.drawings.scale import Flow, grouped, minus, round_step, signed, ticks
from axistwin.drawings.slide import Slide
from axistwin.drawings.switches import Press, Switches, on_slides
from axistwin.drawings.table import NO_TOOL, PIECE, PIECES, Table
from axistwin.drawings.trail import MOST_MOVES, PLACES, POINTS, Trail, Trails, table_axes

__all__ = [
    "MOST_MOVES", "NO_TOOL", "PIECE", "PIECES", "PLACES", "POINTS", "Change", "Drawing", "Figure", "Flow", "Press",
    "Slide", "Switches", "Table", "Trail", "Trails", "asset", "figure", "grouped", "minus", "on_slides",
    "round_step", "signed", "table_axes", "ticks", "used_axes",
]  # fmt: skip
