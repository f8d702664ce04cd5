"""Descriptors, master curves, inverse mode, partition of dissipation and its energy metrics."""
