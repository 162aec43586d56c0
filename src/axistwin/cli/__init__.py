"""Ring 7: what people use: the command line, scenes, conversations, traces, plots."""
