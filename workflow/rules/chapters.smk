"""The thesis: a target for each chapter, the list of all their files, and the report."""


include: "doe.smk"
include: "calibration.smk"
include: "fingerprint.smk"
include: "partition.smk"
include: "yields.smk"
include: "surrogate.smk"


STAGE_OUTPUTS = [
    *DOE_OUTPUTS,
    *CONVERGENCE_OUTPUTS,
    *VIEW_OUTPUTS,
    *CALIBRATION_OUTPUTS,
    *FINGERPRINT_OUTPUTS,
    *FIT_OUTPUTS,
    *PARTITION_OUTPUTS,
    *YIELD_OUTPUTS,
    *DOSE_OUTPUTS,
    *SURROGATE_OUTPUTS,
    *UNCERTAINTY_OUTPUTS,
    *UNCERTAINTY_THESIS_OUTPUTS,
    *HEAT_OUTPUTS,
    # Nine more trainings, each as long as that of the variant `thesis`.
    *(ABLATION_OUTPUTS if CONFIG.surrogate.ablations_in_all else []),
    # A smoke test runs every mill of the box once; the thesis does not use them.
    *(BOX_OUTPUTS if CONFIG.mills.first_case_only else []),
    *(VALIDATION_OUTPUTS if CONFIG.validation.in_all else []),
]


include: "report.smk"


rule chapter2:
    """Chapter 2: the design of the screening runs and its analysis."""
    input:
        DOE_OUTPUTS,
    localrule: True
    message:
        "Chapter 2 is complete"


rule chapter3:
    """Chapter 3: calibration, simulations and master curves."""
    input:
        CALIBRATION_OUTPUTS,
        FINGERPRINT_OUTPUTS,
        FIT_OUTPUTS,
        CONVERGENCE_OUTPUTS,
        VIEW_OUTPUTS,
    localrule: True
    message:
        "Chapter 3 is complete"


rule chapter4:
    """Chapter 4: shares of shear and compression."""
    input:
        PARTITION_OUTPUTS,
    localrule: True
    message:
        "Chapter 4 is complete"


rule chapter5:
    """Chapter 5: yield models and the next experiments."""
    input:
        YIELD_OUTPUTS,
    localrule: True
    message:
        "Chapter 5 is complete"


rule chapter6:
    """Chapter 6: the surrogates of the DEM."""
    input:
        SURROGATE_OUTPUTS,
    localrule: True
    message:
        "Chapter 6 is complete"
