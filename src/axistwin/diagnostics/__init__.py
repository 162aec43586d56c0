"""What is wrong with programs and scenes: the work behind `axistwin check`."""
