"""The chapters of the IF1/IF2 manual, one module each."""
