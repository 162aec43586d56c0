"""Real ports for the controllers of a bench.  The ports use asyncio; pacing uses the wall clock."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.links.bus import LONGEST_LINE, MAX_BLOCK
    from axistwin.links.comport import (
        ComPort,
        Control,
        ModemState,
        Purge,
        SetBreak,
        SetFlow,
        SetLines,
        Suspend,
    )
    from axistwin.links.manual_pacer import ManualPacer
    from axistwin.links.pacing import Pacer, read_speed
    from axistwin.links.plug import CHUNK, FEW, FULL, INSTANT_CHUNK, Plug
    from axistwin.links.serialdev import SerialDevice
    from axistwin.links.server import Server
    from axistwin.links.sharing import Hub, Seat
    from axistwin.links.single_client import Gate
    from axistwin.links.tcp import STALLED, resolved
    from axistwin.links.telnet import (
        IAC,
        LONGEST_SUBNEGOTIATION,
        SB,
        SE,
        Command,
        Negotiation,
        Parser,
        Subnegotiation,
        Verb,
        escape,
    )
    from axistwin.links.urls import PortUrl, parse, parse_as
else:
    __getattr__ = lazy(
        __name__,
        bus="LONGEST_LINE MAX_BLOCK",
        comport="ComPort Control ModemState Purge SetBreak SetFlow SetLines Suspend",
        manual_pacer="ManualPacer",
        pacing="Pacer read_speed",
        plug="CHUNK FEW FULL INSTANT_CHUNK Plug",
        serialdev="SerialDevice",
        server="Server",
        sharing="Hub Seat",
        single_client="Gate",
        tcp="STALLED resolved",
        telnet="Command IAC LONGEST_SUBNEGOTIATION Negotiation Parser SB SE Subnegotiation Verb escape",
        urls="PortUrl parse parse_as",
    )

__all__ = [
    "CHUNK", "FEW", "FULL", "IAC", "INSTANT_CHUNK", "LONGEST_LINE", "LONGEST_SUBNEGOTIATION", "MAX_BLOCK", "SB",
    "SE", "STALLED", "ComPort", "Command", "Control", "Gate", "Hub", "ManualPacer", "ModemState", "Negotiation",
    "Pacer", "Parser", "Plug", "PortUrl", "Purge", "Seat", "SerialDevice", "Server", "SetBreak", "SetFlow",
    "SetLines", "Subnegotiation", "Suspend", "Verb", "escape", "parse", "parse_as", "read_speed",
    "resolved",
]  # fmt: skip
