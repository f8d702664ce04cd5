"""`make bench`: compares millprint with LAMMPS, in speed and in physics."""
