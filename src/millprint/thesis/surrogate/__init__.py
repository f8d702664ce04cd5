"""The surrogate of the simulation: a graph network, its roll-outs, and the measures for them."""
