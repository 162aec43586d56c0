"""Ring 3: the machine that the controllers drive."""
