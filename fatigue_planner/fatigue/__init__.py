"""The joint fatigue model (Eqs. 1 and 2): its parameters, and what a whole cycle does to fatigue."""
