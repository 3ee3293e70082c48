"""Where work is done: in processes of this machine, or on a Dask cluster, with the same results."""
