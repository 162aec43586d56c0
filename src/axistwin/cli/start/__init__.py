"""Commands for the first hour: examples, new scenes, pages, completion."""
