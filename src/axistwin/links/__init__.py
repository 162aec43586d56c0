"""Real ports for the controllers of a bench.  The ports use asyncio; pacing uses the wall clock."""
