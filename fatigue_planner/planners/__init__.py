"""Policies: the paper's baselines, exact lookahead, POMCP and POMCP-Max, and a cost that no policy can beat."""
