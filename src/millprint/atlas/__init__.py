"""The atlas: what a mill of a kind does, from its dimensions, without simulating."""
