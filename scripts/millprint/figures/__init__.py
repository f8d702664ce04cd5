"""Figures, a module a chapter. They draw tables and arrays and compute nothing."""
