"""Comparison of the claims of the thesis with the computed values."""
