"""Recorded motions: files read without trust, their units and axes inferred, and what they say of people."""
