"""The views of the page, one file for each kind of view.

A view is a function that adds elements to the page, and returns a function that updates the elements in each frame.  A
view finds controllers and pins by name in each frame, because the bench may have been replaced.
"""
