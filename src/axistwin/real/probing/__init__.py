"""Compare real controllers with virtual ones."""
