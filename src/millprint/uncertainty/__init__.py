"""How certain a fingerprint is: contact parameters as distributions, sampled, emulated, and turned into intervals."""
