"""Commands for beginners: examples, new scenes, documentation, shell completion."""
