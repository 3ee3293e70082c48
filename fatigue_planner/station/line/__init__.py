"""A line of stations and its crew: who works where in which slot of the shift."""
