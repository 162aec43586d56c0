"""Conversations: the `.talk` text format, and reading, writing, playing, recording and comparing it."""
