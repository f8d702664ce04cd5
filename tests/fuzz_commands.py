"""Fuzzing of command lines: whatever the words and the files that they name, `millprint` ends without a traceback.

    python -m tests.fuzz_commands --count 2000 --seed 1

Each list of words is one of COMMANDS with wrong words, or with one of its files damaged. Nothing is simulated.
"""

import argparse
import contextlib
import io
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from unittest import mock

import numpy as np
import yaml

from millprint.cli import engine
from millprint.cli.commands import main as millprint
from millprint.config.doe import DesignConfig
from millprint.config.included import included_mills
from millprint.thesis.doe.factorial_designs import design_table
from tests.conftest import ROOT
from tests.mutations import mutate_table, mutate_yaml
from tests.unit.own_readings import events, write_condition

DESIGN = {
    "factors": [
        {"symbol": "A", "column": "liquid", "label": "Liquid", "levels": ["None", "ethanol"]},
        {"symbol": "B", "column": "time_h", "label": "Time (h)", "levels": [1, 3]},
    ],
    "replicates": 2,
    "model": ["A", "B"],
    "simulations": 100,
}
REQUEST = {
    "targets": [{"name": "t", "normal_energy_J": 1e-4, "tangential_energy_J": 1e-4}],
    "descriptors": "per_collision",
}
TABLES = {
    "gas.tsv": "case\tgas_volume_ml\ttemperature_k\tpressure_pa\tlimiting_mass_g\nrun#1\t60\t295\t101325\t0.1\n",
    "ph.tsv": "case\tph\ttemperature_k\na\t11\t298\n",
    "charge.tsv": "case\tbpr\tmolar_ratio\tball_mass_g\na\t10\t2\t50\n",
    "wear.tsv": "ball_diameter_mm\tspeed_rpm\ttime_h\tbpr\tunused_mass_g\tused_mass_g\n10\t800\t5\t50\t100\t99.9\n",
    "dose.tsv": "case\tmill\tpowder_mass_g\ttime_h\tfill_ratio\tspeed_rpm\tball_diameter_mm\tyield_percent\n"
    + "".join(f"r{k}\tplanetary\t10\t{k + 1}\t0.2\t400\t10\t{20 + 9 * k}\n" for k in range(6)),
    "warm.tsv": "time_s\ttemperature_degC\n" + "".join(f"{5 * k}\t{20 + 0.02 * k}\n" for k in range(60)),
    "watt.tsv": "time_s\tpower_W\n" + "".join(f"{2 * k}\t{990 + k % 7}\n" for k in range(40)),
    "mine.tsv": "id\tsetup\tquantity\tvalue\tunit\tuncertainty\tuncertainty_unit\nold\tunknown\tpower\t5\tW\t1\tW\n",
}
COMMANDS = [
    "match planetary --like mixer 1500 10 0.3 --speeds 300 450 --balls 8 10 --ranked 3 --out ranked.tsv",
    "match planetary --request request.yaml --densities 7850 --fills 0.15 0.3",
    "match planetary.json --energies 1e-4 1e-4 --frequency 40 --descriptors per_collision",
    "match planetary --like emax 900 10 0.1 --descriptors shear_share --first tangential-share",
    "match --from my_card/card.json --to planetary --near 20 --hours 5",
    "match spex --like mixer 25Hz 10 number=29 --speeds 12Hz 17Hz --equal-frequency --first normal-energy --hours 5",
    "dose dose.tsv planetary.json --out doses.tsv",
    "wet-lab yield gas.tsv out.tsv --config config.yaml",
    "wet-lab half-life ph.tsv out.tsv --config config.yaml",
    "wet-lab charge charge.tsv out.tsv --config config.yaml --dry-gas",
    "wet-lab wear wear.tsv out.tsv --config config.yaml",
    "design design.yaml made --generate B",
    "design design.yaml made",
    "analyse design.yaml runs.tsv analysed",
    "warm my_card warm.tsv --jar-kg 0.5 --start-s 10 --stop-s 200 --table mine.tsv",
    "watt my_card watt.tsv watt.tsv --efficiency 0.6 0.8 --jars 2 --table mine.tsv",
    "wear run --bpr 30 --hours 5 --coefficient c.json",
    "new planetary --name own --no-picture --set radius_mm=30 speeds_rpm=300",
    "new drum --yes --name own --contact steel --no-picture",
    "fingerprint mine.yaml --cores 2",
    "explore planetary",
    "run convergence mine.yaml --dry-run --config name=a",
    "yields model.json conditions.tsv out.tsv --level 0.9 --config config.yaml",
    "animate run.h5 --revolutions 2 --frames-per-revolution 5 --start 0.1",
    "export run.h5 --every 2 --out folder",
    "quantities slice_mill",
    "verify results",
    "crate results",
    "check-crate results",
    "card card.yaml --out o --cores 1",
    "completion",
]
# Of these only the words are wrong: with right files they simulate.
ONLY_REFUSED = ("card",)
WORDS = ["", "0", "-1", "1", "nan", "inf", "1e400", "1e-400", "1,5", "1,041", "10 mm", "0.5", "30", "9" * 400,
         "no.yaml", "mine.yaml", ".", "..", "/proc", "planetary", "mixer", "plantary", "--help", "--", "-x", "--like",
         "--balls", "ä💥", "a" * 300, "x=1", "=", "number=3", "number=", "mass_g=1e9", "radius_mm=", "gas.tsv",
         "design.yaml", "my_card", "run.h5", "planetary.json", "%s", "{}", "\\", "'", "[1, 2", "None",
         ]  # fmt: skip


def make_folder(folder: Path) -> dict[Path, bytes]:
    """Write valid files for every command; returns the content of each."""
    for name, text in TABLES.items():
        (folder / name).write_text(text)
    (folder / "design.yaml").write_text(yaml.safe_dump(DESIGN))
    (folder / "request.yaml").write_text(yaml.safe_dump(REQUEST))
    (folder / "config.yaml").write_bytes((ROOT / "config/config.yaml").read_bytes())
    (folder / "mine.yaml").write_text("name: mine\nmill: planetary\n")
    (folder / "card.yaml").write_text(
        "name: a\nmill: planetary\nspeed_rpm: 400\nballs: {diameter_mm: 0, fill_ratio: 0.2}\n"
    )
    found = next((ROOT / "src").rglob("planetary.json"), None) or next(ROOT.rglob("planetary.json"))
    shutil.copyfile(found, folder / "planetary.json")
    table = design_table(DesignConfig(factors=DESIGN["factors"], replicates=DESIGN["replicates"]))
    table["yield_percent"] = np.random.default_rng(1).normal(50, 10, len(table)).round(1)
    table.to_csv(folder / "runs.tsv", sep="\t", index=False)
    (folder / "conditions.tsv").write_bytes((ROOT / "config/data/conditions.tsv").read_bytes())
    write_condition(folder / "my_card", *events(np.random.default_rng(7), 1.0, 25.0), 1.0, 5.0)
    (folder / "run.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(64))
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def wrong_words(words: list[str], rng: random.Random) -> list[str]:
    """The words with one to three of them changed, lost, doubled, exchanged or added; the command stays."""
    words = list(words)
    for _ in range(rng.choice([1, 1, 2, 3])):
        place, kind = rng.randrange(1, len(words) + 1), rng.random()
        if kind < 0.5 and place < len(words):
            words[place] = rng.choice(WORDS)
        elif kind < 0.65:
            words.insert(place, rng.choice(WORDS))
        elif kind < 0.8 and place < len(words):
            del words[place]
        elif place < len(words):
            other = rng.randrange(1, len(words))
            words[place], words[other] = words[other], words[place]
    return words


def damage(path: Path, rng: random.Random) -> None:
    """Damage a file as a person, an export or a broken copy does."""
    content = path.read_bytes()
    if path.suffix in (".tsv", ".yaml") and rng.random() < 0.8:
        changed = (mutate_table if path.suffix == ".tsv" else mutate_yaml)(content.decode(), rng)
        path.write_bytes(changed.encode(errors="surrogatepass"))
        return
    place = rng.randrange(len(content) + 1)
    odd = rng.choice([b"", b"\0", b"{}", b"[]", b"null", b"\xff\xfe", b'"', b"#", b"1", bytes(rng.randbytes(9))])
    path.write_bytes(rng.choice([content[:place], content[:place] + odd + content[place + 1 :], odd, odd + content]))


def outcome_of(words: list[str]) -> str:
    """The exit status of a command, or the traceback; a refusal without a line is a fault too."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
            mock.patch.object(engine, "run_python", lambda _: 0),
            mock.patch("builtins.input", side_effect=EOFError),
        ):
            status = millprint(words)
    except SystemExit as ended:
        status = ended.code
    except BaseException:
        return traceback.format_exc(limit=-6)
    said = err.getvalue() + out.getvalue()
    if status and (not said.strip() or "Traceback" in said):
        return f"status {status}: {said[-300:]!r}"
    return str(status or 0)


def fuzz(count: int, seed: int, folder: Path) -> tuple[Counter, list[str]]:
    """Run `count` wrong commands in a folder; returns how often each status came, and the faults."""
    files, rng = make_folder(folder), random.Random(seed)
    statuses, faults = Counter(), []
    assert included_mills()
    with contextlib.chdir(folder):
        for number in range(count):
            words = rng.choice(COMMANDS).split()
            named = [
                path for path in files if any(str(path.relative_to(folder)).startswith(word) for word in words[1:])
            ]
            if named and words[0] not in ONLY_REFUSED and rng.random() < 0.5:
                hurt = rng.choice(named)
                damage(hurt, rng)
                about = f"{words}, damaged {hurt.name}: {hurt.read_bytes()[:200]!r}"
            else:
                words = wrong_words(words, rng)
                about = f"{words}"
            found = outcome_of(words)
            statuses[found if len(found) < 5 else "fault"] += 1
            if len(found) >= 5:
                faults.append(f"{number}, seed {seed}: {about}\n{found}")
            for path in sorted(folder.rglob("*"), reverse=True):
                if path not in files and path.is_file():
                    path.unlink()
                elif path.is_dir() and not any(path.iterdir()):
                    path.rmdir()
            for path, content in files.items():
                if not path.exists() or path.read_bytes() != content:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(content)
    return statuses, faults


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="command lines")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        # A folder within it, so that `..` is in it too.
        place = Path(folder).resolve() / "here"
        place.mkdir()
        statuses, faults = fuzz(options.count, options.seed, place)
    print(*faults, f"{dict(statuses)}", sep="\n")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
