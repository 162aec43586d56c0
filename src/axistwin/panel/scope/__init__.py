"""The oscilloscope without its page: recording, view, measurement and files."""
