"""The way in: the examples and pages that come with axistwin, and new scenes."""
