"""millprint: the mechanical fingerprint of a ball mill, from its geometry and motion to chemistry."""

import gc
import os

# Host, process and start time of the run that started a job, passed in the environment: see millprint.liveness.
RUN_VARIABLE = "MILLPRINT_RUN"

if RUN_VARIABLE in os.environ:
    # What a job imports lives as long as the job. To look it through for what could be thrown away, over and over,
    # takes up to a quarter of the time to import it; millprint.job lets the collector begin with what comes after.
    gc.disable()
