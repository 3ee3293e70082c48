"""The report of an experiment's results, and the comparison of two results folders."""
