"""The grid of conditions, lengths and policies: its trials, their tables, regret and bounds."""
