"""What a run says at its end: what was made, where to look first, what to do next; or what failed and what to try."""
