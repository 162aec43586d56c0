"""One package per controller family; families do not import one another."""
