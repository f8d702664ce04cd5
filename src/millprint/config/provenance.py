"""The section `provenance`: who runs, and under which licence the results are."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Section

# The identifier of a person at orcid.org; its last sign may be an X.
ORCID = r"^(|\d{4}-\d{4}-\d{4}-\d{3}[\dX])$"
# A name of the list at spdx.org/licenses, or an address.
LICENCE = r"^(|[A-Za-z0-9.+-]+|https?://\S+)$"


class ProvenanceConfig(Section):
    """What the record of a run, `ro-crate-metadata.json`, says of the person who runs it. No result depends on it."""

    agent: Annotated[str, Field(max_length=200)] = ""
    """name of the person who made the run; if it is empty, the record names nobody"""
    orcid: Annotated[str, Field(pattern=ORCID)] = ""
    """ORCID of that person, such as 0000-0002-1825-0097"""
    affiliation: Annotated[str, Field(max_length=200)] = ""
    """institution of that person"""
    licence: Annotated[str, Field(pattern=LICENCE)] = ""
    """licence of the results, a name of spdx.org/licenses such as CC-BY-4.0 or an address; empty: millprint's"""
