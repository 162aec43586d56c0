"""The oscilloscope without its user interface: recording, view, measurement and files."""
