"""Vessels (facets, STL, signed distance) and their motions."""
