"""Draw pictures of a run or of a trace."""
