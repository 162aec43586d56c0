"""Record the changes of signals on a bench to a file (a trace); read and compare traces."""
