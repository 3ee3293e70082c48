"""The tasks of experiments, and problems of your own, as environments for planners from outside (Gymnasium)."""
