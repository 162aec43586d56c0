"""Conversations: the `.talk` text format, and reading, writing, playing, recording and comparing it."""

from axistwin.bench.talk.conversation import load, write

__all__ = ["load", "write"]
