"""Figures, a module for each chapter. They draw tables and arrays and compute nothing."""
