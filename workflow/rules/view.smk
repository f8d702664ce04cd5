"""Files for ParaView and animations of any case with snapshots."""


rule export_run:
    input:
        run=f"{CASE}/run.h5",
    output:
        balls=f"{CASE}/run.vtkhdf",
        walls=f"{CASE}/run_walls.vtkhdf",
        contacts=f"{CASE}/run_contacts.vtkhdf",
    log:
        f"{LOGS}/view/{{mill}}/{{contact}}/{{case}}_export.log",
    benchmark:
        f"{BENCHMARKS}/export_run/{{mill}}/{{contact}}/{{case}}.tsv"
    params:
        every=CONFIG.view.paraview_every,
    message:
        "Writing {wildcards.mill}/{wildcards.contact}/{wildcards.case} for ParaView"
    script:
        "../../scripts/export_run.py"


rule animate_run:
    input:
        run=f"{CASE}/run.h5",
    output:
        gif=f"{CASE}/mill.gif",
        # Snakemake's report shows a PNG, even an animated one, but offers a GIF only as a download.
        png=report(
            f"{CASE}/mill.png",
            caption="../report/mill.rst",
            category="Chapter 3",
            labels={"figure": "animation", "shows": "balls in the mill, {mill}/{contact}/{case}"},
        ),
    log:
        f"{LOGS}/view/{{mill}}/{{contact}}/{{case}}_animate.log",
    benchmark:
        f"{BENCHMARKS}/animate_run/{{mill}}/{{contact}}/{{case}}.tsv"
    params:
        settings=CONFIG.view.model_dump(mode="json", exclude={"paraview_every"}),
    message:
        "Animating {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/animate_run.py"


VIEW_OUTPUTS = [f"{RESULTS}/dem/{path}/mill.{kind}" for path in cases_of_sweep("movie") for kind in ("gif", "png")]
