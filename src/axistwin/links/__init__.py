"""Ring 5: how the outside reaches a port.  asyncio and the wall clock live here."""
