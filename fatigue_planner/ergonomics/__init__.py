"""What ergonomic methods say of a reaction: its posture over the cycle, and one file per indicator."""
