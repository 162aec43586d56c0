"""Tutor and lessons: explanations for new users in the terminal, the panel and the playground."""

from axistwin.teaching.lessons import Lesson, course
from axistwin.teaching.pupil import Pupil
from axistwin.teaching.tutor import Tutor

__all__ = ["Lesson", "Pupil", "Tutor", "course"]
