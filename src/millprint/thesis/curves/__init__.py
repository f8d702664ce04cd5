"""Chapters 3 and 4: the printed curves and conditions, and the curves of all mills and balls."""
