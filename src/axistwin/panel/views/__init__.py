"""The views of the page, a file for each kind.

A view is a function that adds elements at the present place of the page, and returns a function that updates them in
each frame.  A view finds all objects by name, because the bench may be replaced.
"""
