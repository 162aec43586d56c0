"""One package for each controller family; families do not import each other."""
