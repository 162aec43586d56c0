"""Requests of the shadow's own to a board on a bus, while no host is connected to it."""

import asyncio
import re
from asyncio import StreamReader, StreamWriter
from collections.abc import Callable

from axistwin.controllers.compumotor.registers import Control, Status
from axistwin.real.shadow.asking import PATIENCE_S, Question
from axistwin.real.shadow.dialects.compumotor import MESSAGE

POLL_S = 0.002
NOBODY = 0xFF  # Status byte while no board drives the bus.


class BoardAsker:
    """Asks its questions at a bus socket.  `tell` receives what the twin hears: True for a request."""

    def __init__(self, questions: tuple[Question, ...], tell: Callable[[bool, bytes], object]) -> None:
        self._questions, self.tell = questions, tell
        self._left: list[Question] = []
        self.begin()

    def begin(self) -> None:
        """Ask everything before the next host is connected: the twin knows nothing of the board."""
        self._left = list(self._questions)

    async def ask(self, reader: StreamReader, writer: StreamWriter) -> bool:
        """Ask what is left, unless a message waits for a host.  Return False if the board has not answered."""
        try:
            async with asyncio.timeout(PATIENCE_S):
                status = await self._status(reader, writer)
                enable = 0 if status & Status.MASKED else Control.INTERRUPT_ENABLE
                ready = status != NOBODY and status & (Status.INPUT_READY | Status.MESSAGE_READY) == Status.INPUT_READY
                while ready and self._left:
                    message = await self._message(reader, writer, self._left[0].data, enable)
                    if re.match(self._left[0].busy, message, re.DOTALL):
                        break
                    self._left.pop(0)
        except (TimeoutError, OSError, ValueError):
            return False
        return True

    async def _message(self, reader: StreamReader, writer: StreamWriter, command: bytes, enable: int) -> bytes:
        await self._line(reader, writer, f"w 0 {command.hex(' ')}")
        await self._line(reader, writer, f"w 1 {Control.COMMAND_READY | enable:02x}")
        while not await self._status(reader, writer) & Status.MESSAGE_READY:
            await asyncio.sleep(POLL_S)
        message = bytes.fromhex(await self._line(reader, writer, f"r 0 {MESSAGE}"))
        await self._line(reader, writer, f"w 1 {Control.MESSAGE_TAKEN | enable:02x}")
        return message

    async def _status(self, reader: StreamReader, writer: StreamWriter) -> int:
        return int(await self._line(reader, writer, "r 1"), 16)

    async def _line(self, reader: StreamReader, writer: StreamWriter, request: str) -> str:
        sent = f"{request}\n".encode()
        self.tell(True, sent)
        writer.write(sent)
        answer = await reader.readline()
        if not answer:
            raise ConnectionResetError
        self.tell(False, answer)
        return answer.decode("ascii")
