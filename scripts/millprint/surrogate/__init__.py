"""The graph-network surrogate of the simulation: dataset, network, training, roll-out, evaluation."""
