"""The `contact` variant: a pair of bodies is solved by physics, what they do to each other's pairs is learned."""
