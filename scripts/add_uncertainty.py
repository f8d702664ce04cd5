"""Adds the intervals by contact parameters, and by the shape of a fitted jar, to the fingerprint of a mill."""

from millprint.fingerprint.bands import FURTHER, read_factors
from millprint.fingerprint.model import Fingerprint
from millprint.job import job


def main(fingerprint: str, factors: dict[str, str], output: str) -> Fingerprint:
    """Write the fingerprint with the factors of each origin, whose files are given by its name, and return it."""
    plain = Fingerprint.read(fingerprint)
    further = {origin: read_factors(path, origin, plain.about) for origin, path in factors.items()}
    found = plain.with_further(further)
    found.write(output)
    return found


if "snakemake" in globals():
    with job(snakemake.log[0], f"intervals of {snakemake.wildcards.mill}") as logger:
        given = {origin: snakemake.input.get(origin) for origin in FURTHER}
        found = main(
            snakemake.input.fingerprint,
            {origin: str(path) for origin, path in given.items() if path},
            snakemake.output.fingerprint,
        )
        for origin, factors in found.further.items():
            logger.info("%s: fill ratios from %g to %g", FURTHER[origin].title, *factors.fill_range)
