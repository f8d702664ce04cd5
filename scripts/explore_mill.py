"""Builds the explorer of a mill: one page with its fingerprint, which needs no server."""

from millprint.explorer.page import explorer_content, explorer_page
from millprint.files import whole_file
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.search import simulated_request
from millprint.job import job


def main(fingerprint: str, output: str, name: str, title: str) -> None:
    """Write the page of a fingerprint, whose search covers what was simulated."""
    request = simulated_request(Fingerprint.read(fingerprint))
    with whole_file(output) as partial:
        partial.write_text(explorer_page(explorer_content(name, title, [fingerprint], request)))


if "snakemake" in globals():
    with job(snakemake.log[0], "explore mill"):
        main(snakemake.input.fingerprint, snakemake.output.html, **snakemake.params.about)
