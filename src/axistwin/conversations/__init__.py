"""Conversations: what is said and done to the controllers on a bench, as text; who plays it, and who writes it down."""
