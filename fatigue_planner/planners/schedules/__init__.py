"""Schedules: sequences of actions that are repeated for ever, whatever is observed; what they cost, and the best."""
