"""millprint from its own folder: plain `snakemake` makes all of workflow/Snakefile."""


include: "workflow/Snakefile"


# A file that is included cannot set the default target.
rule everything:
    input:
        rules.all.input,
    localrule: True
