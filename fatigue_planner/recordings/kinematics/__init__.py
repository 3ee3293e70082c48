"""From points to angles: a person's own lengths and markers, and the posture of every frame."""
