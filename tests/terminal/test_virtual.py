"""A virtual controller at a terminal, in an event loop with a fake clock."""

import asyncio
import io

import pytest

from axistwin import Bench, Session
from axistwin.ui.terminal.commands import LocalCommands
from axistwin.ui.terminal.screen import Screen
from axistwin.ui.terminal.virtual import SerialEnd

from ..sessions.driving import drive

PATIENCE_S = 300


def motor() -> Bench:
    bench = Bench()
    bench.add("smartmotor")
    return bench


@pytest.mark.parametrize("command", [":axes", ":pins", ":why", ":next", ":explain index"])
def test_a_command_that_reads_the_motor_leaves_the_pacer_awake(command):
    """Reading a SmartMotor can schedule an event, which the pacer must execute."""

    async def main():
        out = io.StringIO()
        screen = Screen(out, person=False, colours=False)
        end = SerialEnd(Session(motor, None), screen.show_received)
        commands = LocalCommands(end, screen, end)
        end.send(b"RTEMP\r")
        for _ in range(3):
            await asyncio.wait_for(end.run_until_quiet(), PATIENCE_S)
            await commands.obey(command)
        await asyncio.wait_for(end.run_until_quiet(), PATIENCE_S)
        end.close()
        screen.close()
        assert out.getvalue()

    drive(main())
