"""How a worker moves for an action: tasks, the whole-body quadratic program (Eq. 3), simulation and verification."""
