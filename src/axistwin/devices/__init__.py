"""What a controller of your own is made of."""
