"""Pictures of a run or of a trace."""
