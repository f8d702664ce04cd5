"""The target `dose`: for the thesis all of it, for another mill what its own sweep gives."""

# Written by the jobs of the fingerprint.
MILL_SPECTRA = [
    path.format(mill=CONFIG.mill)
    for path in (*rules.describe_mill.output, *rules.draw_spectra.output)
    if path.startswith(f"{DOSE}/")
]


rule dose:
    input:
        DOSE_OUTPUTS if CHAPTERS else MILL_SPECTRA,
    localrule: True
    message:
        "Energy spectra and dose are complete"
