"""What is on the page, a file for each kind of thing.

A view is a function that puts elements where the page has got to, and returns what brings them up to date; that is
called for each frame.  It asks for everything by name, as another bench may have taken the place of the one before.
"""
