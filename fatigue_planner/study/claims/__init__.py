"""A paper's statements, judged by the runs of a benchmark."""
