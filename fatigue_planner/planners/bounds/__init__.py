"""A lower bound on the cost of every policy, from quadratic functions of fatigue; see `cost_bound.py`."""
