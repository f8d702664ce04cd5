"""What the tables of a calibration call things; apart from the experiments, since claims read tables alone."""

SIMULATED, MEASURED = "simulated", "measured"
FRICTION_PAIR = ("static_friction", "rolling_friction")
