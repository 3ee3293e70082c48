"""From recordings to reactions: phases, torques on the cycle's ticks, and how far they can be believed."""
