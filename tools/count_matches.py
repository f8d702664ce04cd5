"""Counts how often one included mill can do what another does: python tools/count_matches.py.

The middle of what was simulated of each mill is asked of each other mill, in every sense of SENSES. Writes
docs/how_to/match_pairs.tsv, a row for each pair and sense, the table of docs/how_to/match.md, and what the example of
that page and of README prints.
"""

import contextlib
import io
import itertools
import math
import re
from pathlib import Path

import pandas as pd

from millprint.cli.commands import main as millprint
from millprint.config.charge import ONE_SIZE
from millprint.config.fingerprint import SearchConfig
from millprint.estimate.judge import VERDICTS
from millprint.fingerprint.condition_search import ranges_of, rank_conditions, target_at
from millprint.fingerprint.match_words import best_of, setting_in_words
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.observables.condition import Condition
from millprint.run.files import read_table, whole_file, write_table

TABLE, PAGE = "docs/how_to/match_pairs.tsv", "docs/how_to/match.md"
EXAMPLE = "match planetary --like emax 900 10 0.1 --hours 5"
# What is asked for, in words, and as a search; the last asks for more than it judges.
ENDS = ("", "_mean_lower", "_mean_upper")
SENSES = {
    "both weighted energies within 30 %, the same dose by time": SearchConfig(),
    "within 50 %": SearchConfig(near_percent=50),
    "the weighted frequencies too, within 30 %": SearchConfig(equal_frequency=True),
    "the mean energies of a collision, within 30 %": SearchConfig(descriptors="per_collision"),
    "the weighted normal energy and the share of shear, within 30 %": SearchConfig(descriptors="shear_share"),
    "only the weighted normal energy, within 30 %": SearchConfig(first="weighted_normal_energy_J"),
}


def middle_of(fingerprint: Fingerprint) -> Condition[float]:
    """The middle of what was simulated: speed and fill ratio in the geometric middle, balls of the middle size."""
    ranges = fingerprint.about["ranges"]
    speed, fill = (math.sqrt(math.prod(ranges[name])) for name in ("speed_hz", "fill_ratio"))
    sizes = ranges_of(SearchConfig(), fingerprint)["ball_diameters_mm"]
    return fingerprint.condition(speed_hz=speed, fill_ratio=fill, ball_diameter_mm=sizes[len(sizes) // 2])


def match_pair(like: Fingerprint, mill: Fingerprint, sense: str) -> dict:
    """A row for what one mill is asked of another."""
    request = SENSES[sense]
    target = target_at(like, middle_of(like), ONE_SIZE, [mill], request)
    best = best_of(rank_conditions(target, [mill], request))
    row = {"like": like.about["mill"], "mill": best["mill"], "sense": sense, "verdict": best["verdict"]}
    if request.first:
        row["verdict"] = VERDICTS[0] if request.first in best["met"].split(", ") else best["verdict"]
    ratios = {f"{name}_ratio{end}": best[f"{name}_ratio{end}"] for name in target.asked for end in ENDS}
    times = {f"time_ratio{end}": best[f"time_ratio{end}"] for end in ENDS}
    return {**row, "setting": setting_in_words(best), **times, **ratios}


def block(pairs: pd.DataFrame) -> str:
    """The table of the page, and which pairs are met."""
    found = (
        pairs.groupby("sense")["verdict"].value_counts().unstack(fill_value=0).reindex(columns=VERDICTS, fill_value=0)
    )
    lines = ["| asked for | met | not met | not known |", "|---|---|---|---|"]
    lines += [f"| {sense} | {' | '.join(str(found.loc[sense, word]) for word in VERDICTS)} |" for sense in SENSES]
    first = pairs[(pairs["sense"] == next(iter(SENSES))) & (pairs["verdict"] == VERDICTS[0])]
    met = first.groupby("like", sort=False)["mill"].agg(", ".join)
    said = "; ".join(f"what {like} does, on {mills}" for like, mills in met.items())
    return "\n".join([*lines, "", f"Met in the first sense: {said}.", ""])


def example() -> str:
    """What the command of the example prints, without the line that says where the fingerprint comes from."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        millprint(EXAMPLE.split())
    return "\n".join(["```text", *printed.getvalue().splitlines()[1:], "```", ""])


def write_block(page: str, name: str, text: str) -> None:
    """Write a block of a page, between comments with its name."""
    block = re.compile(rf"(<!-- {name}: python tools/count_matches.py -->\n).*?(<!-- end -->)", re.S)
    before = Path(page).read_text()
    with whole_file(page) as draft:
        draft.write_text(block.sub(lambda found: found[1] + text + found[2], before))


def main() -> None:
    """Write the table of pairs and the blocks of the pages."""
    known = [Fingerprint.read(str(find_ready_made(name))) for name in ready_made()]
    pairs = itertools.permutations(known, 2)
    rows = [match_pair(like, mill, sense) for like, mill in pairs for sense in SENSES]
    write_table(pd.DataFrame(rows), TABLE)
    write_block(PAGE, "pairs", block(read_table(TABLE)))
    for page in (PAGE, "README.md"):
        write_block(page, "example", example())


if __name__ == "__main__":
    main()
