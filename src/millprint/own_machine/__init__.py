"""A prediction held against the mill of one's own laboratory: by its sound, its warmth, its electric power."""
