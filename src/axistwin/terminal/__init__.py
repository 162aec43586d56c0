"""What a person at `axistwin term` talks to."""
