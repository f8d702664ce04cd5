"""Checks of a whole configuration before the first job; the checks of each room are in its own `*_checks` module."""
