"""Surrogates of the simulation: two variants, their roll-outs, and the measures for both."""
