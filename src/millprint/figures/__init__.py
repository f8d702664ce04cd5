"""Figures, a module for each topic. They draw tables and arrays and compute nothing."""
