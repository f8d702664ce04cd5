"""millprint: the mechanical fingerprint of a ball mill, from its geometry and motion to chemistry."""

import gc
import os

# Host, process and start time of the run that started a job, passed in the environment: see millprint.liveness.
RUN_VARIABLE = "MILLPRINT_RUN"

if RUN_VARIABLE in os.environ:
    # The garbage collector would examine imported modules again and again, which takes up to a quarter of the import
    # time, although they live as long as the job. It is off during imports; millprint.job turns it on.
    gc.disable()
