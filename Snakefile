"""For plain `snakemake` in the folder of millprint: Makes the target `all` of workflow/Snakefile."""


include: "workflow/Snakefile"


# A file that is included cannot set the default target.
rule everything:
    input:
        rules.all.input,
    localrule: True
    message:
        "Everything is complete"
