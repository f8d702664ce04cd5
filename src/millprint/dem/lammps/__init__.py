"""LAMMPS as the engine of a simulation: the input that expresses a case of ours, the run, and what it gives."""
