"""A prediction compared with the mill of one's own laboratory: by its sound, its warmth, its electric power."""
