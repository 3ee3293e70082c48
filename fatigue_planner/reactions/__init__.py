"""Postural reactions and their cache: keys, the HDF5 layout, verification, archives from elsewhere."""
