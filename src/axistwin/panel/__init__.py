"""The panel: a web page that shows a bench and controls it.

No other package imports NiceGUI, which the extra `[panel]` installs.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.panel.actions import State
    from axistwin.panel.context import Common, Context, careful, together
    from axistwin.panel.gate import PERSON, Gate, is_loopback
    from axistwin.panel.memory import AT_A_TIME, Memory, release
    from axistwin.panel.people import People
    from axistwin.panel.talk import KEPT, Printer, Talk
    from axistwin.panel.turns import breathe, in_turns
    from axistwin.panel.web import Address, Panel
else:
    __getattr__ = lazy(
        __name__,
        actions="State",
        gate="PERSON Gate is_loopback",
        context="Common Context careful together",
        memory="AT_A_TIME Memory release",
        people="People",
        talk="KEPT Printer Talk",
        turns="breathe in_turns",
        web="Address Panel",
    )

__all__ = [
    "AT_A_TIME",
    "KEPT",
    "PERSON",
    "Address",
    "Common",
    "Context",
    "Gate",
    "Memory",
    "Panel",
    "People",
    "Printer",
    "State",
    "Talk",
    "breathe",
    "careful",
    "in_turns",
    "is_loopback",
    "release",
    "together",
]  # fmt: skip
