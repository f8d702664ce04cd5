# millprint on a slim Python image, without a GPU. docs/how_to/container.md says how to build it and how to run it.
FROM python:3.11-slim-bookworm

# make runs the targets, git tells results the commit they are from, libgomp1 is what threads of the libraries load.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends git libgomp1 make \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home miller

USER miller
WORKDIR /home/miller/millprint

# Packages first: a layer that stays as long as the lock file does. The index has torch without gigabytes of CUDA.
ARG TORCH_INDEX=https://download.pytorch.org/whl/cpu
COPY --chown=miller envs/requirements.lock envs/torch.lock envs/
RUN python -m venv .venv \
    && .venv/bin/pip install --quiet --no-cache-dir --no-compile --require-hashes --requirement envs/requirements.lock \
    && .venv/bin/pip install --quiet --no-cache-dir --no-compile --require-hashes --no-deps --extra-index-url "$TORCH_INDEX" \
       --requirement envs/torch.lock

# With the files `installed` and `complete`, make takes the environment as that of the lock file.
COPY --chown=miller . .
RUN .venv/bin/pip install --quiet --no-cache-dir --no-deps --editable . \
    && touch .venv/installed .venv/complete \
    && mkdir -p .numba_cache results
ENV PATH=/home/miller/millprint/.venv/bin:$PATH

# Kernels are compiled at the first run, for the processor that it finds, and kept here.
VOLUME ["/home/miller/millprint/results", "/home/miller/millprint/.numba_cache"]

CMD ["make", "smoke"]
