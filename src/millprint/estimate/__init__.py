"""Numbers with their intervals, and verdicts on them; it knows nothing of mills."""
