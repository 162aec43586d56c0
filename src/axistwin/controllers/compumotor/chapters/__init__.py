"""The chapters of the 1810/1811 manual, one module each."""
