"""Conversations: the `.talk` text format, and reading, writing, playing, recording and comparing it."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.conversations.comparison import Comparison, compare, recorded_times
    from axistwin.conversations.conversation import Conversation, load, parse, seconds, write
    from axistwin.conversations.player import Difference, play
    from axistwin.conversations.recorder import recording, recording_to
else:
    __getattr__ = lazy(
        __name__,
        comparison="Comparison compare recorded_times",
        conversation="Conversation load parse seconds write",
        player="Difference play",
        recorder="recording recording_to",
    )

__all__ = [
    "Comparison", "Conversation", "Difference", "compare", "load", "parse", "play", "recorded_times", "recording",
    "recording_to", "seconds", "write",
]  # fmt: skip
