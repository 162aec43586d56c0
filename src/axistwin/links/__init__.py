"""Real ports for the controllers of a bench.  Only this package uses asyncio and the wall clock."""
