"""A rehearsal: a real server process, a simulated worker and robot that talk to it as real ones do, and faults."""
