"""A run with a server, whose job says how often it is interrupted. With the variable JOB it is that job."""

import os
import signal
import subprocess
import sys
import time

from millprint.cases import server


def wait() -> None:
    """Wait for an interruption, and for a second one."""
    for word in ("begun", "ended"):
        try:
            print(word, flush=True)
            time.sleep(1)
        except KeyboardInterrupt:
            print("interrupted", flush=True)


if __name__ == "__main__":
    if "JOB" not in os.environ:
        server.start(sys.executable)
        signal.signal(signal.SIGINT, lambda *_: None)
        subprocess.run([sys.executable, __file__], env={**os.environ, "JOB": "1"})
    elif not server.is_served():
        wait()
