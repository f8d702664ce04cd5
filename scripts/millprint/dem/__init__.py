"""The discrete element method: contact law, walls, neighbours, step loop, ledger, collisions, store."""
