"""A bench that is driven by people, and that can be run again: what was done to it is kept, moment by moment."""
