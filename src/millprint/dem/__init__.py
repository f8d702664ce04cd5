"""The discrete element method: contact law, walls, neighbours, step loop, ledger, collisions, store."""

# The version of the physics: every simulation runs again when it changes. An edit of the code that a simulation runs is
# found without it (millprint.run.digest).
PHYSICS = 1
