"""Diagnostics of programs for the IF1 and IF2."""
