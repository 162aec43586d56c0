"""Commands that run programs and scenes, and commands for their traces."""
