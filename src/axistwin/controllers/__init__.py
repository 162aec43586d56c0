"""Ring 4: one package per family; families do not import one another."""
