"""What everything stands on: errors, units, numbers, storage and the version."""
