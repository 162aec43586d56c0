"""What machines look like: drawings whose parts are moved, and listings whose lines are marked.

A drawing is sent to the browser once.  After that only what has changed goes there, a message for each frame.
"""
