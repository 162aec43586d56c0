"""Conversations: the `.talk` text format, and reading, writing, playing, recording and comparing it."""

from axistwin.conversations.conversation import load, write

__all__ = ["load", "write"]
