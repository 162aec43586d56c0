"""Tutor and lessons: explanations for new users in the terminal, the panel and the playground."""
