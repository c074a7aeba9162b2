"""Studies on two processes of Dask, beside two bare processes and one."""
