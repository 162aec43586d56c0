"""Tutor and lessons: explanations for new users in the terminal, the panel and the playground."""

from axistwin.teaching.commands import own_command
from axistwin.teaching.lessons import STARTED_S, Lesson, course
from axistwin.teaching.pupil import Pupil
from axistwin.teaching.remedies import Remedies
from axistwin.teaching.tutor import Tutor

__all__ = ["STARTED_S", "Lesson", "Pupil", "Remedies", "Tutor", "course", "own_command"]
