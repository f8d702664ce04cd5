"""Functions of the rules: the files and values that a rule asks for, by wildcards. Names are looked up when a job asks."""

import math


@cache
def identity_of(mill: str, contact: str) -> dict:
    """What decides the numbers of every simulation of a mill with a contact set."""
    return shared_identity(mill_named(mill), CONTACTS[contact], CONFIG.dem)


def identity_at(wildcards) -> dict:
    """What decides the numbers of the simulation of a case."""
    shared = identity_of(wildcards.mill, wildcards.contact)
    return identity(case_at(wildcards), shared, CONFIG.dem, CASE.format(**wildcards))


def identity_inside(mills, contacts, rules=()) -> dict:
    """What decides the numbers of simulations that have no case in results/dem.

    rules: names of the counting rules that count in them. They have a closure_max of their own; whether they keep
    overlap_max is recorded nowhere, so that it counts.
    """
    return {
        "mills": [mill_identity(mill, CONFIG.dem.counts_by_facet) for mill in mills],
        "contacts": [contact_identity(contact) for contact in contacts],
        "dem": dem_identity(CONFIG.dem) | {"overlap_max": CONFIG.dem.overlap_max},
        "counting_rules": [rule for rule in rules_named() if rule["name"] in rules],
    }


def shape_of(mill: str) -> list[str]:
    """The file of a fitted jar's shape, if the search of the fit is a part of the whole run."""
    fitted = fitted_mill(CONFIG, MILLS) if CHAPTERS and "fit" in CONFIG.also else None
    if fitted is None or fitted.name != mill or CONFIG.fit.search.screening.jars < FEWEST_JARS:
        return []
    return [f"{RESULTS}/uncertainty/{fitted.name}/shape.json"]


def predicting_chapter(contact: str) -> str:
    """The fingerprint of chapter 3 of a contact set: with all its intervals if the whole run has their analysis."""
    analysed = CONFIG.mill in CONFIG.uncertainty.mills and contact == CONFIG.mills.contact_set
    folder = f"{RESULTS}/uncertainty/{CONFIG.mill}" if analysed else f"{RESULTS}/fingerprint"
    return f"{folder}/fingerprint_{contact}.json"


def uncertainty_of(mills) -> list[str]:
    """Every file of the uncertainty of some mills, and their fingerprints with the intervals."""
    own = expand([*rules.measure_uncertainty.output, *rules.add_uncertainty.output], mill=mills)
    # The curves of chapter 3 are those of the run's mill.
    chapter = [f"{RESULTS}/uncertainty/{CONFIG.mill}/fingerprint_{CONFIG.mills.contact_set}.json"]
    return [*own, *(chapter if CHAPTERS and CONFIG.mill in mills else [])]


def spectra_rules(own: str) -> list[str]:
    """The counting rules of spectra; the first is the rule of the descriptors, which the figures show."""
    return list(dict.fromkeys([own, *CONFIG.dose.spectra.counting_rules]))


def rules_named(*names: str) -> list[dict]:
    """The counting rules of these names, in this order, as plain values; all rules without names."""
    known = {rule.name: rule.model_dump(mode="json") for rule in CONFIG.dem.counting_rules}
    return [known[name] for name in dict.fromkeys(names or known)]


def records_of(summaries) -> list[str]:
    """The records, run.h5, next to these summaries."""
    return [str(Path(path).with_name("run.h5")) for path in summaries]


def swept_summaries(contact: str) -> list[str]:
    """The summaries of the sweeps' conditions with a contact set, as for the descriptors."""
    return [f"{RESULTS}/dem/{path}/summary.json" for path, case in DESCRIBED_CASES.items() if case.contact == contact]


def explored(names) -> dict[str, list[str]]:
    """The files that the page of some mills is made from, in the order of the mills."""
    files = {key: [path.format(mill=name) for name in names] for key, path in OF_MILL.items()}
    return {"fingerprint": [predicting(name) for name in names], **files}


def card_intervals(name: str) -> list[str]:
    """The fingerprint with intervals by contact parameters, if the whole run has their analysis for the mill."""
    mill = CARD_EXPERIMENTS[name].mill
    return [predicting(mill)] if mill in CONFIG.uncertainty.mills else []


def setup_inputs(name: str) -> dict:
    """Section, mill and contact sets of a set-up, as plain values."""
    setup = CONFIG.validation.chosen[name]
    return {
        "settings": setup.model_dump(mode="json"),
        "mill": dumped(MILLS[setup.mill_name]) if setup.mill_name else None,
        "contacts": [CONTACTS[each].model_dump(mode="json") for each in setup.contact_names],
    }


def identity_of_setup(name: str) -> dict:
    """What decides the numbers of a set-up's own simulations, apart from its settings."""
    setup = CONFIG.validation.chosen[name]
    mills = [MILLS[setup.mill_name]] if setup.mill_name else []
    return identity_inside(mills, [CONTACTS[each] for each in setup.contact_names])


def setup_runs(name: str) -> list[str]:
    """The files that a set-up reads of its simulations."""
    rows, files = rows_of("SET_UP", name), CONFIG.validation.chosen[name].run_files
    return [path for row in rows for file in files for path in files_of([row], file)]


def own_tables(name: str) -> list[str]:
    """The tables of the simulations that a set-up runs on its own."""
    return [f"{VALIDATION}/{name}/{table}" for table in CONFIG.validation.chosen[name].own_tables]


def bed_sizes(name: str) -> tuple[float, float]:
    """The radius of the drum of a set-up and the diameter of its balls [m]."""
    case = rows_of("SET_UP", name)[0].case
    return MILLS[case.mill].geometry.radius_mm / 1e3, case.ball_diameter_m


def simulated(case: str) -> str:
    """The file of a simulation, with its snapshots."""
    return f"{RESULTS}/dem/{case}/run.h5"


def tests_of(variant: str) -> list[str]:
    """The tests in which a variant is rolled out: all tests; for an ablation only the test on the training motion."""
    return [CONFIG.surrogate.trained_test] if variant in ABLATED else SURROGATE_TESTS


def measured_trainings(variant: str) -> list[str]:
    """The tables of measures of every training of a variant or ablation, of its roll-outs and of its single steps."""
    trainings = CONFIG.surrogate.trainings_of(variant)
    return [f"{SURROGATE}/{name}/{table}.tsv" for name in trainings for table in ("metrics", "single_steps")]


def edges_of(variant: str) -> dict:
    """The rules for the edges of a variant, as plain values."""
    return CONFIG.surrogate.variant(variant).edges.model_dump(mode="json")


def rollout_in(variant: str, test: str) -> dict:
    """Settings, case with its simulation, and starts of a variant's roll-out in a test."""
    chosen = CONFIG.surrogate.tests[test]
    return {
        "settings": CONFIG.surrogate.rollout_of(variant, test).model_dump(mode="json"),
        "case": chosen.case,
        "run": simulated(chosen.case),
        "starts_s": chosen.starts_s,
    }


def weights_for(variant: str) -> str:
    """The weights for the roll-out of a variant: its own, or those of another variant."""
    return f"{SURROGATE}/{CONFIG.surrogate.weights_of(variant)}/weights.pt"


def compared_runs(tests) -> dict[str, str]:
    """The reference simulations of some tests, named `test_role`."""
    cases = {test: CONFIG.surrogate.tests[test].runs() for test in tests}
    return {f"{test}_{role}": simulated(case) for test in tests for role, case in cases[test].items()}


def starts_in(tests) -> dict[str, float]:
    """The tests in which the balls move, with their first starts [s]; single steps are evaluated from there."""
    moving = [test for test in tests if test in MOVING_TESTS]
    return {test: CONFIG.surrogate.tests[test].starts_s[0] for test in moving}


def changes(variant: str) -> str:
    """The settings that an ablation changes, as text."""
    own = CONFIG.surrogate.ablations[variant]
    sections = ("graph", "edges", "network", "training", "rollout")
    keys = {f"{section}.{key}": value for section in sections for key, value in getattr(own, section).items()}
    return ", ".join(f"{key} = {value}" for key, value in keys.items()) or "nothing"


def reported_figures(paths, results) -> list[dict]:
    """Path in the folder of results, category, labels and caption of those paths that the report shows as a picture."""
    flagged = [
        (item, item.flags["report"]) for each in workflow.rules for item in each.output if "report" in item.flags
    ]
    found = []
    for path in dict.fromkeys(str(path) for path in paths):
        if not path.endswith((".svg", ".png")):
            continue
        for item, about in flagged:
            if item.match(path):
                inside = str(Path(path).relative_to(results))
                with workflow.sourcecache.open(about.caption, "r") as file:
                    caption = file.read()
                listed = {"path": inside, "stage": about.category, "labels": about.labels, "caption": caption}
                found.append(listed)
                break
    return found


def declared(job) -> dict[str, float]:
    """Time, memory and disk of a simulation, and what another job's rule declares."""
    if job.rule.name.endswith("run_dem_case"):
        own = resources_at(job.wildcards)
        times = {name: math.ceil(getattr(own, name)) for name in ("processor_s", "processor_max_s", "disk_mb")}
        return {**times, "mem_mb": own.memory_mb}
    found = {name: job.resources.get(name) for name in ("processor_s", "mem_mb")}
    return {name: value for name, value in found.items() if isinstance(value, (int, float))}


def jobs_to_run() -> list[Job]:
    """The jobs that are going to run, as a plan counts them."""
    return [
        Job(job.rule.name, job.threads, tuple(map(str, job.output)), declared(job))
        for job in workflow.dag.needrun_jobs()
        if job.output
    ]


def check_geometry():
    """Check what needs geometry or physics, once for each input; ends the program with a line for each fault."""
    check_once(
        CONFIG, CHECKED_MILLS, CONTACTS, SOURCE, PYTHON, ["millprint.thesis.chapter_checks"] if CONFIG.chapters else []
    )
