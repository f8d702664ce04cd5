"""Ranks the conditions of one mill that come nearest to a condition of another, with what is lost in each.

Settings: mills.match, fingerprint.descriptors.
Inputs: fingerprints of the `mill` and of the one that it is to be `like`.
Outputs: the table of conditions.
"""

from millprint.config.fingerprint import DescriptorSet, LikeConfig, MatchConfig, TargetConfig
from millprint.config.mill_sweep import MatchMillsConfig
from millprint.fingerprint.comparison import match_in_words
from millprint.fingerprint.condition_search import match_targets, shared_contact, simulated_ranges
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import write_table
from millprint.run.job import job


def request_of(
    settings: MatchMillsConfig, like: str, fingerprint: Fingerprint, descriptors: DescriptorSet
) -> MatchConfig:
    """The request: ranges that the settings do not give are those of the simulations of the mill."""
    condition = LikeConfig(
        fingerprint=like,
        speed_rpm=settings.like_speed_rpm,
        ball_diameter_mm=settings.like_ball_diameter_mm,
        **settings.like_charge,
    )
    given = {"speeds_rpm": settings.speeds_rpm, "ball_diameters_mm": settings.ball_diameters_mm}
    content = simulated_ranges([fingerprint]) | {key: value for key, value in given.items() if value}
    target = TargetConfig(name=settings.like_mill, like=condition)
    return MatchConfig(targets=[target], descriptors=descriptors, ranked=settings.ranked, **content)


if "snakemake" in globals():
    with job(snakemake.log[0], "match mills") as logger:
        settings = MatchMillsConfig(**snakemake.params.settings)
        mill = Fingerprint.read(snakemake.input.mill)
        request = request_of(settings, snakemake.input.like, mill, snakemake.params.descriptors)
        table = match_targets(request, [mill])
        write_table(table, snakemake.output[0])
        logger.info("%s", match_in_words(table, request, [mill]))
        for note in shared_contact(request, [mill]):
            logger.info("%s", note)
