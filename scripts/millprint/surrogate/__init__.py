"""Surrogates of the simulation: two variants, what rolls them out, and the measures that both are held to."""
