"""The figures, each drawn from a table that is published beside it."""
