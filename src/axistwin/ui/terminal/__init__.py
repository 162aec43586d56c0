"""The terminal of `axistwin term`: its screen, its commands, and its connection to a controller or a port."""
