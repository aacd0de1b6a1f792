"""A bed made by several processes: on this machine, or on those of a Dask cluster."""
