"""The views of the page, one file for each kind of view.

A view is a function that adds elements to the page, and returns a function that updates the elements in each frame.  A
view finds controllers and pins by name in each frame, because the bench may have been replaced.
"""

from axistwin.panel.views.asides import Asides, PanelRemedies
from axistwin.panel.views.darkness import MODES
from axistwin.panel.views.driving import SPEEDS, driving
from axistwin.panel.views.faults import faults, power
from axistwin.panel.views.front import front, generic
from axistwin.panel.views.lessons import on_the_page
from axistwin.panel.views.machines import machines
from axistwin.panel.views.operator import operator
from axistwin.panel.views.people import people
from axistwin.panel.views.pins import pins
from axistwin.panel.views.program import program
from axistwin.panel.views.scope import Scopes, scope
from axistwin.panel.views.table import table
from axistwin.panel.views.tabs import tabs
from axistwin.panel.views.terminal import terminal

__all__ = [
    "MODES", "SPEEDS", "Asides", "PanelRemedies", "Scopes", "driving", "faults", "front", "generic", "machines",
    "on_the_page", "operator", "people", "pins", "power", "program", "scope", "table", "tabs", "terminal",
]  # fmt: skip
