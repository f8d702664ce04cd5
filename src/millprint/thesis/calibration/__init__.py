"""Virtual calibration: contact coefficients from the motion of a ball in a jar (thesis Sec. 3.2.2)."""
