"""Ring 2: what a commanded motion is made of."""
