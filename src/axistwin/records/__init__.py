"""What a bench has done: traces and plots."""
