"""Stand-in for a broken controller: an emulated controller drives real motors through a motion board.

The motion board runs Klipper's micro-controller firmware.  This package implements the firmware's documented protocol.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.standin.board import Board, State
    from axistwin.standin.channel import Channel
    from axistwin.standin.clock_fit import ClockFit
    from axistwin.standin.dictionary import Dictionary
    from axistwin.standin.driver import Driver
    from axistwin.standin.events import Failed, InputChanged, Ready, Stopped
    from axistwin.standin.journal import Journal, last_positions
    from axistwin.standin.klipper import KlipperBoard
    from axistwin.standin.motors import Motor, motor
    from axistwin.standin.real_time import PRIORITY, real_time_priority
    from axistwin.standin.sender import Sender
    from axistwin.standin.stop_page import StopPage
    from axistwin.standin.timetable import Timetable
    from axistwin.standin.wiring import AxisPins, BoardPin, DrivenAxis, InputPin, OutputPin, Sensed, Switched, Wiring
else:
    __getattr__ = lazy(
        __name__,
        board="Board State",
        channel="Channel",
        clock_fit="ClockFit",
        dictionary="Dictionary",
        driver="Driver",
        events="Failed InputChanged Ready Stopped",
        klipper="KlipperBoard",
        journal="Journal last_positions",
        motors="Motor motor",
        real_time="PRIORITY real_time_priority",
        sender="Sender",
        stop_page="StopPage",
        timetable="Timetable",
        wiring="AxisPins BoardPin DrivenAxis InputPin OutputPin Sensed Switched Wiring",
    )

__all__ = [
    "PRIORITY", "AxisPins", "Board", "BoardPin", "Channel", "ClockFit", "Dictionary", "DrivenAxis", "Driver",
    "Failed", "InputChanged", "InputPin", "Journal", "KlipperBoard", "Motor", "OutputPin", "Ready", "Sender", "Sensed",
    "State", "StopPage", "Stopped", "Switched", "Timetable", "Wiring", "last_positions", "motor",
    "real_time_priority",
]  # fmt: skip
