"""The search of any problem: legal, preferred and widened actions, ends, sparse children, beliefs in nodes."""
