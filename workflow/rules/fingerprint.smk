"""Descriptors, master curves, universal curves and the inverse mode (thesis chapter 3)."""

from millprint.fingerprint.cases import described_cases

FINGERPRINT = f"{RESULTS}/fingerprint"
FINGERPRINT_FIGURES = f"{FINGERPRINT}/figures"
DESCRIBED_CASES = described_cases(CONFIG, CASES)
# Values that the thesis prints; those that are claims are in the second table.
PUBLISHED = [CONFIG.data.published, CONFIG.data.claims]


wildcard_constraints:
    contact="|".join(CONTACTS),


rule tabulate_descriptors:
    input:
        summaries=[f"{RESULTS}/dem/{path}/summary.json" for path in DESCRIBED_CASES],
        published=PUBLISHED,
    output:
        descriptors=f"{FINGERPRINT}/descriptors.tsv",
        counting_rules=f"{FINGERPRINT}/counting_rules.tsv",
        cycles=f"{FINGERPRINT}/cycles.tsv",
        densities=f"{FINGERPRINT}/cycle_densities.tsv",
        table_3_5=f"{FINGERPRINT}/table_3_5.tsv",
    log:
        f"{LOGS}/fingerprint/tabulate_descriptors.log",
    localrule: True
    params:
        mill=CONFIG.mill,
        counting_rule=CONFIG.fingerprint.counting_rule,
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
    message:
        "Tabulating the descriptors of every condition"
    script:
        "../../scripts/tabulate_descriptors.py"


rule fit_master_curves:
    input:
        descriptors=rules.tabulate_descriptors.output.descriptors,
        counting_rules=rules.tabulate_descriptors.output.counting_rules,
    output:
        means=expand(f"{FINGERPRINT}/means_{{contact}}.tsv", contact=CONFIG.contacts),
        curves=expand(f"{FINGERPRINT}/curves_{{contact}}.tsv", contact=CONFIG.contacts),
        fingerprint=expand(f"{FINGERPRINT}/fingerprint_{{contact}}.json", contact=CONFIG.contacts),
        coverage=expand(f"{FINGERPRINT}/coverage_{{contact}}.tsv", contact=CONFIG.contacts),
        collapse=f"{FINGERPRINT}/collapse.tsv",
        universal=f"{FINGERPRINT}/universal.tsv",
        exponents=f"{FINGERPRINT}/exponents.tsv",
        zones=f"{FINGERPRINT}/zones.tsv",
    log:
        f"{LOGS}/fingerprint/fit_master_curves.log",
    benchmark:
        f"{BENCHMARKS}/fit_master_curves/fit_master_curves.tsv"
    params:
        mill=CONFIG.mill,
        contacts=CONFIG.contacts,
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        interval=CONFIG.fingerprint.interval,
        smooth_points=CONFIG.fingerprint.smooth_points,
    message:
        "Fitting the master curves of {CONFIG.contacts}, and measuring how well the scaling collapses them"
    script:
        "../../scripts/fit_master_curves.py"


rule invert_master_curves:
    input:
        fingerprints=rules.fit_master_curves.output.fingerprint,
        published=PUBLISHED,
        others=[target.like.fingerprint for target in CONFIG.fingerprint.inverse.targets if target.like],
    output:
        inverse=f"{FINGERPRINT}/inverse.tsv",
        ranked=f"{FINGERPRINT}/inverse_ranked.tsv",
    log:
        f"{LOGS}/fingerprint/invert_master_curves.log",
    localrule: True
    params:
        settings=CONFIG.fingerprint.inverse.model_dump(mode="json"),
        contacts=CONFIG.contacts,
    message:
        "Searching the conditions that give the target descriptors"
    script:
        "../../scripts/invert_master_curves.py"


rule plot_fingerprint:
    input:
        descriptors=rules.tabulate_descriptors.output.descriptors,
        cycles=rules.tabulate_descriptors.output.cycles,
        densities=rules.tabulate_descriptors.output.densities,
        means=rules.fit_master_curves.output.means,
        curves=rules.fit_master_curves.output.curves,
        zones=rules.fit_master_curves.output.zones,
        universal=rules.fit_master_curves.output.universal,
        exponents=rules.fit_master_curves.output.exponents,
        published=PUBLISHED,
        runs=[path for contact in CONFIG.contacts for path in mapped_runs(contact).values()],
        spectra=expand(f"{DOSE}/spectra_{{contact}}.tsv", contact=CONFIG.contacts),
    output:
        densities_svg=report(
            f"{FINGERPRINT_FIGURES}/cycle_densities.svg",
            caption="../report/cycle_densities.rst",
            category="Chapter 3",
            labels={"figure": "3.5", "shows": "dissipation per revolution"},
        ),
        densities_png=f"{FINGERPRINT_FIGURES}/cycle_densities.png",
        means_svg=report(
            f"{FINGERPRINT_FIGURES}/cycle_means.svg",
            caption="../report/cycle_means.rst",
            category="Chapter 3",
            labels={"figure": "3.6", "shows": "mean dissipation per revolution"},
        ),
        means_png=f"{FINGERPRINT_FIGURES}/cycle_means.png",
        energies_svgs=[
            report(
                f"{FINGERPRINT_FIGURES}/energies_{contact}.svg",
                caption="../report/energies.rst",
                category="Chapter 3",
                labels={"figure": "3.7, 3.8", "shows": f"energy and frequency of collisions, {contact}"},
            )
            for contact in CONFIG.contacts
        ],
        energies_pngs=expand(f"{FINGERPRINT_FIGURES}/energies_{{contact}}.png", contact=CONFIG.contacts),
        curves_svgs=[
            report(
                f"{FINGERPRINT_FIGURES}/master_curves_{contact}.svg",
                caption="../report/master_curves.rst",
                category="Chapter 3",
                labels={"figure": "3.11, 3.12, 4.2", "shows": f"master curves, {contact}"},
            )
            for contact in CONFIG.contacts
        ],
        curves_pngs=expand(f"{FINGERPRINT_FIGURES}/master_curves_{{contact}}.png", contact=CONFIG.contacts),
        universal_svg=report(
            f"{FINGERPRINT_FIGURES}/universal_curves.svg",
            caption="../report/universal_curves.rst",
            category="Chapter 3",
            labels={"figure": "3.14", "shows": "universal master curves"},
        ),
        universal_png=f"{FINGERPRINT_FIGURES}/universal_curves.png",
        exponents_svg=report(
            f"{FINGERPRINT_FIGURES}/exponents.svg",
            caption="../report/exponents.rst",
            category="Chapter 3",
            labels={"figure": "Eqs 3.28, 3.29", "shows": "exponents of the scaling"},
        ),
        exponents_png=f"{FINGERPRINT_FIGURES}/exponents.png",
        maps_svgs=[
            report(
                f"{FINGERPRINT_FIGURES}/maps_{contact}.svg",
                caption="../report/maps.rst",
                category="Chapter 3",
                labels={"figure": "3.9, 3.10", "shows": f"heat map and granular temperature, {contact}"},
            )
            for contact in CONFIG.contacts
        ],
        maps_pngs=expand(f"{FINGERPRINT_FIGURES}/maps_{{contact}}.png", contact=CONFIG.contacts),
        maps_tsvs=expand(f"{FINGERPRINT_FIGURES}/maps_{{contact}}.tsv", contact=CONFIG.contacts),
        spectra_svgs=[
            report(
                f"{DOSE}/spectra_{contact}.svg",
                caption="../report/spectra.rst",
                category="Chapter 3",
                labels={"figure": "energy spectra", "shows": f"energies of single collisions, {contact}"},
            )
            for contact in CONFIG.contacts
        ],
        spectra_pngs=expand(f"{DOSE}/spectra_{{contact}}.png", contact=CONFIG.contacts),
    log:
        f"{LOGS}/fingerprint/plot_fingerprint.log",
    localrule: True
    params:
        mill=CONFIG.mill,
        contacts=CONFIG.contacts,
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
        maps=[mapped_runs(contact) for contact in CONFIG.contacts],
        titles=[f"{MILLS[CONFIG.mill].title}, contact set {contact}" for contact in CONFIG.contacts],
        counting_rule=CONFIG.fingerprint.counting_rule,
        conditions=CONFIG.fingerprint.maps.model_dump(mode="json"),
    message:
        "Drawing the figures of chapter 3: revolutions, master curves, their scaling, maps, and energy spectra"
    script:
        "../../scripts/plot_fingerprint.py"


FINGERPRINT_OUTPUTS = [
    *rules.tabulate_descriptors.output,
    *rules.fit_master_curves.output,
    *rules.invert_master_curves.output,
    *rules.plot_fingerprint.output,
]
