"""The thesis: one target a chapter, all of them together, and the report."""


include: "convergence.smk"
include: "view.smk"
include: "calibration.smk"
include: "fingerprint.smk"
include: "fit.smk"
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
    *SURROGATE_OUTPUTS,
    # A smoke test runs every mill of the box once; the thesis has no need of them.
    *(BOX_OUTPUTS if CONFIG.mills.first_case_only else []),
]


include: "report.smk"


localrules:
    chapter2,
    chapter3,
    chapter4,
    chapter5,
    chapter6,


rule chapter2:
    input:
        DOE_OUTPUTS,


rule chapter3:
    input:
        CALIBRATION_OUTPUTS,
        FINGERPRINT_OUTPUTS,
        FIT_OUTPUTS,
        CONVERGENCE_OUTPUTS,
        VIEW_OUTPUTS,


rule chapter4:
    input:
        PARTITION_OUTPUTS,


rule chapter5:
    input:
        YIELD_OUTPUTS,


rule chapter6:
    input:
        SURROGATE_OUTPUTS,
