"""The digital human: skeleton, anthropometry, ranges of motion, strengths, and its export as URDF."""
