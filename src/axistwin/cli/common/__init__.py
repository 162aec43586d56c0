"""Parameters and targets that commands share."""
