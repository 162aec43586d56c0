"""Steps of a protocol core: requests to send, to receive, or to wait.

A function of a core is a generator: it yields steps, receives their results, and returns its own result.  The modules
`blocking` (pyserial) and `asynchronous` (asyncio) execute the steps.
"""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Write:
    """A request to send bytes to the controller."""

    data: bytes


@dataclass(frozen=True)
class Read:
    """A request to receive at least one byte within `timeout` seconds.  The result is b"" if no byte arrives."""

    timeout: float


@dataclass(frozen=True)
class Pause:
    """A request to wait for some seconds."""

    seconds: float


@dataclass(frozen=True)
class Clock:
    """A request for the time in seconds, from an arbitrary origin."""


Step = Write | Read | Pause | Clock
Procedure = Generator[Step, Any, T]
"""A generator of steps that returns a T: a function of a protocol core."""
