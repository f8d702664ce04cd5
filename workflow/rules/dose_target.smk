"""The target `dose`: for the thesis all of it, for another mill what its own sweep gives."""


rule dose:
    input:
        DOSE_OUTPUTS if CHAPTERS else MILL_SPECTRA,
    localrule: True
