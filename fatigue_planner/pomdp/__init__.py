"""The decision problem: POMDPs, the fatigue POMDP, the worker's choice (Eq. 4), hidden workers, cyclic plans."""
