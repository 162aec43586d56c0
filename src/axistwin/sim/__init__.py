"""Virtual time, pins and lines.  This package uses no wall clock, no threads and no sockets."""

from axistwin.sim.clock import Clock, Procedure, Process, interrupt, kill
from axistwin.sim.frames import FASTEST_BAUD, Break, LineError, Parity, UartFormat
from axistwin.sim.levels import Levels, Space
from axistwin.sim.manual_actions import ManualActions, by_itself
from axistwin.sim.pins import Pin, SensedPin, UserPin, connect
from axistwin.sim.progress import Progress
from axistwin.sim.registers import CONTROL, DATA, NOBODY_DRIVES, Init, ReadData, RegisterPort, WriteRegister
from axistwin.sim.serial import MANY, Line, Uart
from axistwin.sim.serial_port import (
    X_OFF,
    X_ON,
    DropPending,
    Flow,
    Hold,
    SendBreak,
    SerialPort,
    SetFlow,
    SetFormat,
    SetInstant,
    SetLine,
    Write,
)
from axistwin.sim.signal import Signal
from axistwin.sim.wirings import Pair, daisy_chain, direct, join, shared_pair

__all__ = [
    "CONTROL", "DATA", "FASTEST_BAUD", "MANY", "NOBODY_DRIVES", "X_OFF", "X_ON", "Break", "Clock", "DropPending",
    "Flow", "Hold", "Init", "Levels", "Line", "LineError", "ManualActions", "Pair", "Parity", "Pin", "Procedure",
    "Process", "Progress", "ReadData", "RegisterPort", "SendBreak", "SensedPin", "SerialPort", "SetFlow",
    "SetFormat", "SetInstant", "SetLine", "Signal", "Space", "Uart", "UartFormat", "UserPin", "Write",
    "WriteRegister", "by_itself", "connect", "daisy_chain", "direct", "interrupt", "join", "kill", "shared_pair",
]  # fmt: skip
