"""Yield models on milling conditions and mechanical descriptors (thesis chapter 5)."""
