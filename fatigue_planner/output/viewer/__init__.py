"""Motions in three dimensions, as one page that opens offline, and as filmstrips."""
