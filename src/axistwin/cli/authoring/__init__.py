"""Commands for authors of programs and scenes: errors, listings, editors."""
