"""The simulations of a run: one table of them, what each is made for, and several in one job."""
