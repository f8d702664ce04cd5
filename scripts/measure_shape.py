"""What the fit of a jar leaves open of its shape, as factors on what its fingerprint predicts.

Settings: fit, fingerprint.counting_rule, fingerprint.interval; the mill.
Inputs: `search` (fit_search.tsv) and `published`.
Outputs: `shape`.
"""

from millprint.config.fit import JarSearch
from millprint.config.mill import MillConfig
from millprint.run.files import read_table, write_json
from millprint.run.job import job
from millprint.thesis.curves.regimes import read_published
from millprint.thesis.fit.jar_search import JAR_PARAMETERS, parameters_of
from millprint.thesis.fit.open_shape import shape_factors
from millprint.thesis.fit.published import published_values


def main(search: str, published: list[str], output: str, mill: MillConfig, settings: JarSearch, about: dict) -> None:
    """Write shape.json; `about` holds counting_rule and probability."""
    values = published_values(read_published(*published), settings.contact)
    factors = shape_factors(
        read_table(search, numeric=JAR_PARAMETERS, text=["counting_rule"]),
        dict(zip(values["name"], values["published"], strict=True)),
        settings,
        parameters_of(mill.geometry),
        mill=mill.name,
        **about,
    )
    write_json(factors.model_dump(mode="json"), output)


if "snakemake" in globals():
    with job(snakemake.log[0], "what the fit leaves open of the shape of the jar"):
        main(
            snakemake.input.search,
            list(snakemake.input.published),
            snakemake.output.shape,
            MillConfig(**snakemake.params.mill),
            JarSearch(**snakemake.params.settings),
            dict(snakemake.params.about),
        )
