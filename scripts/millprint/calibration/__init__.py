"""Virtual calibration: contact coefficients from what a ball does in a jar (thesis Sec. 3.2.2)."""
