"""Comparison with LAMMPS, in speed and in physics: `make bench`, or `python -m benchmarks`."""
