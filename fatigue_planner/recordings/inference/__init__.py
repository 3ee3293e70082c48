"""What a file leaves open, inferred over its whole length, told, and overridable: labels, rate, unit, axes, plates."""
