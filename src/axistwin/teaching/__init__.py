"""The tutor and the lessons: words for newcomers, made from the command tables, for terminal, panel and playground."""

from axistwin.teaching.lessons import Lesson, course
from axistwin.teaching.pupil import Pupil
from axistwin.teaching.tutor import Tutor

__all__ = ["Lesson", "Pupil", "Tutor", "course"]
