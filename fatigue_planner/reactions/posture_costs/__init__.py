"""What the posture of a reaction costs besides fatigue: a share of the cycle, by kind; see `posture_cost.py`."""
