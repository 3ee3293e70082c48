"""The page that compares a worker's body, strengths and torques with the literature."""
