"""`make bench`: millprint and LAMMPS side by side, for speed and as a check of the physics."""
