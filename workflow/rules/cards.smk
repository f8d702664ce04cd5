"""Milling cards of a table of experiments (section `cards`): results/cards."""

CARD = f"{RESULTS}/cards/{{card}}"


rule write_card:
    input:
        sources=lambda wildcards: shape_files(CARD_EXPERIMENTS[wildcards.card].mill),
        summaries=lambda wildcards: files_of(rows_of("CARD", wildcards.card)),
        runs=lambda wildcards: files_of(rows_of("CARD", wildcards.card), "run.h5"),
        uncertainty=lambda wildcards: card_intervals(wildcards.card),
        wear=[f"{RESULTS}/dose/wear_coefficient.json"] if CHAPTERS else [],
        materials=local(CONFIG.dose.wear.materials),
    output:
        card=f"{CARD}/card.json",
        figure=figures(f"{CARD}/card"),
        pdf=f"{CARD}/card.pdf",
        tsv=f"{CARD}/card.tsv",
        methods=f"{CARD}/methods.txt",
        table=f"{CARD}/table.tex",
        references=f"{CARD}/references.bib",
        animation=[f"{CARD}/mill.gif"] if CONFIG.cards.animation else [],
    log:
        f"{LOGS}/cards/{{card}}.log",
    benchmark:
        f"{BENCHMARKS}/write_card/{{card}}.tsv"
    wildcard_constraints:
        card=any_of(CARD_EXPERIMENTS),
    resources:
        processor_s=lambda wildcards: round(OTHER_S) + TABLE.processor_s(animated(wildcards.card)),
    params:
        experiment=lambda wildcards: CARD_EXPERIMENTS[wildcards.card].model_dump(mode="json"),
        cases=lambda wildcards: [row.case.model_dump(mode="json") for row in rows_of("CARD", wildcards.card)],
        mill=lambda wildcards: dumped(MILLS[CARD_EXPERIMENTS[wildcards.card].mill]),
        contact=lambda wildcards: TABLE.contact_of(wildcards.card).model_dump(mode="json"),
        settings={
            "counting_rule": CONFIG.mills.rule,
            "interval": CONFIG.fingerprint.interval,
            "dose": CONFIG.dose.model_dump(mode="json"),
        },
        rules=rules_named(*spectra_rules(CONFIG.mills.rule)),
        dem=settings("dem"),
        animation=CONFIG.cards.animation,
    message:
        "Writing the milling card {wildcards.card}"
    script:
        "../../scripts/write_card.py"


rule match_cards:
    input:
        cards=expand(rules.write_card.output.card, card=CARD_EXPERIMENTS),
        fingerprints=[predicting(name) for name in CONFIG.cards.match],
    output:
        table=f"{RESULTS}/cards/match.tsv",
        verdict=f"{RESULTS}/cards/match.txt",
    log:
        f"{LOGS}/cards/match.log",
    localrule: True
    params:
        descriptors=CONFIG.fingerprint.descriptors,
    message:
        "Matching {CONFIG.cards.match} to the milling cards"
    script:
        "../../scripts/compare_mills.py"


CARD_OUTPUTS = expand([*rules.write_card.output], card=CARD_EXPERIMENTS)


rule cards:
    """A milling card for each experiment of the section cards."""
    input:
        CARD_OUTPUTS,
        rules.match_cards.output if CARD_EXPERIMENTS and CONFIG.cards.match else [],
