"""A prediction compared with the mill of one's own laboratory: by its warmth and its electric power."""
