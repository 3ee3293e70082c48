"""What one looks at before believing the torques of a recording."""
