"""The oscilloscope without its page: what is recorded, how it is seen, measured and saved."""
