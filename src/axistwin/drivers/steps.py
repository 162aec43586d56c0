"""Steps of a protocol core: the requests of a core to its shell.

A function of a core is a generator: it yields steps, receives their results, and returns its own result.  A shell
executes the steps: `blocking` on pyserial, `asynchronous` on asyncio.
"""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Write:
    """Send bytes."""

    data: bytes


@dataclass(frozen=True)
class Read:
    """Receive at least one byte, or b"" after `timeout` seconds."""

    timeout: float


@dataclass(frozen=True)
class Pause:
    """Wait."""

    seconds: float


@dataclass(frozen=True)
class Clock:
    """Return the time in seconds, from an arbitrary origin."""


Step = Write | Read | Pause | Clock
Procedure = Generator[Step, Any, T]
"""A function of a core that returns a T."""
