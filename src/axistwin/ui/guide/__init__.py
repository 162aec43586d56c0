"""Help for new users: the examples and pages that come with axistwin, and a generator of new scenes."""
