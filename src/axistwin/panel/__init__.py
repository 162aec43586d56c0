"""The panel: a web page that shows a bench and controls it.

No other package imports NiceGUI, which the extra `[panel]` installs.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.panel.actions import State
    from axistwin.panel.context import Common, Context, careful, together
    from axistwin.panel.gate import PERSON, Gate
    from axistwin.panel.lessons import Lessons
    from axistwin.panel.memory import AT_A_TIME, Memory, release
    from axistwin.panel.outbound import ELEMENTS_AT_A_TIME, Outbound
    from axistwin.panel.page import KEPT_PAGES, Visits, build_page, build_views
    from axistwin.panel.people import People
    from axistwin.panel.talk import KEPT, Printer, Talk
    from axistwin.panel.turns import breathe, in_turns
    from axistwin.panel.web import Address, Panel, listening_socket
else:
    __getattr__ = lazy(
        __name__,
        actions="State",
        context="Common Context careful together",
        gate="Gate PERSON",
        lessons="Lessons",
        memory="AT_A_TIME Memory release",
        outbound="ELEMENTS_AT_A_TIME Outbound",
        page="KEPT_PAGES Visits build_page build_views",
        people="People",
        talk="KEPT Printer Talk",
        turns="breathe in_turns",
        web="Address Panel listening_socket",
    )

__all__ = [
    "AT_A_TIME", "ELEMENTS_AT_A_TIME", "KEPT", "KEPT_PAGES", "PERSON", "Address", "Common", "Context", "Gate",
    "Lessons", "Memory", "Outbound", "Panel", "People", "Printer", "State", "Talk", "Visits", "breathe",
    "build_page", "build_views", "careful", "in_turns", "listening_socket", "release", "together",
]  # fmt: skip
