"""Interactive sessions: run, pause and step a bench, and go back in time by replaying all external input."""
