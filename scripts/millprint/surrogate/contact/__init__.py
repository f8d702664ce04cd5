"""The `contact` variant: each pair of bodies is solved by physics, the coupling of the pairs is learned."""
