"""The report of a shift beside a robot: a worker's own, and what is said of five or more together; and the card."""
