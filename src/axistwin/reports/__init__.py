"""Text reports of a run: messages and moves."""
