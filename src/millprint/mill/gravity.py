"""The acceleration of gravity, one for everything that is simulated or compared with a simulation."""

GRAVITY = 9.81  # [m/s2]
