"""What a worker's preferences are, learnt from cycles whose reactions were recognised."""
