"""How policies are compared: paired tests, intervals, effect sizes, equivalence, Holm's correction."""
