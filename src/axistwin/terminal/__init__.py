"""The terminal of `axistwin term`: screen, commands, and the controller or port at the other end."""
