"""The experiment file: its schema, defaults, checks and messages, and what is built from it."""
