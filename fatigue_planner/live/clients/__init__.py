"""Clients of the face, a process each: they translate between it and a device, and nobody trusts what they say."""
