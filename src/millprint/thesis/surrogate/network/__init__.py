"""The `thesis` variant and its other readings: a signed-distance graph network of balls and wall (Sec. 6.2)."""
