"""Design of experiments: fractions and aliases, analysis of variance, wet-lab arithmetic."""
