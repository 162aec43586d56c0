"""Why a controller does not move, with the remedy: for each family, and for every other device."""
