"""Names in the tables of a calibration; in a module without the experiments, since claims read only tables."""

SIMULATED, MEASURED = "simulated", "measured"
FRICTION_PAIR = ("static_friction", "rolling_friction")
