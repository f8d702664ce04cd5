"""How cost grows with the size of a run: planning, fitting and asking, pages, simulations; for `measure_growth.py`."""
