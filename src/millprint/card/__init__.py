"""The milling card: what one experiment in a mill was, in numbers, for a paper and for other mills."""
