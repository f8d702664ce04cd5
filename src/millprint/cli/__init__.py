"""The command `millprint`: a thin layer over Snakemake and the library. Each module here is one command."""
