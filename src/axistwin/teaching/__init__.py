"""The tutor: words for newcomers, made from the command tables, for the terminal, the panel and the playground."""

from axistwin.teaching.tutor import Tutor

__all__ = ["Tutor"]
