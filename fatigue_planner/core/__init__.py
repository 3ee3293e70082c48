"""Infrastructure: errors, strict settings, files, YAML, provenance, random streams, compilation, processes and Dask."""
