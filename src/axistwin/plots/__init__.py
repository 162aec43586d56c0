"""Pictures of what has happened, from a run or from a trace."""
