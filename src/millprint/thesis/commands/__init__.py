"""Commands of `millprint` for designs of experiments, readings from the laboratory, and yields."""
