"""Machines and impacts that others measured, predicted by the DEM without a fit.

How a set-up becomes a verdict:

1. `config/data/measured.tsv` holds what was measured: `validation.measured` reads it. A row names the set-up
   that predicts it, or `unknown`.
2. A set-up is a file of config/validation: its kind, settings and assumptions. The class of a kind's settings is in
   millprint/config/setup_models.py, and how it is predicted in `millprint.validation.setups.PREDICTED`.
3. Its simulations, `SetupConfig.sweeps`, are cases in results/dem like any other. A set-up without sweeps, such as an
   impact, simulates inside `predict`. Its mill is a file in config/mills, its contact sets are in config/contacts.
4. The rule `predict_setup` calls its `predict(Inputs)`. It returns the table with the columns `PREDICTION_COLUMNS`, a
   row for each number: `id` of the measured row (empty for a prediction without one), `x` (in the unit of the measured
   row's x; empty for a single number), `quantity` and `unit` (as in the measured row), `model` (`DEM`, or the name of a
   formula that is drawn as a reference line), `predicted`, `lower` and `upper` (empty if there is no interval), and
   `interval`: the origin of the interval, one of `INTERVALS`.
5. `validation.verdicts` compares the rows of the model `DEM` with the measured ones, at the measured x.
   A prediction must have a row at each measured x. `explanations` tests whether a variant of the prediction explains a
   miss, and `coverage` counts the numbers within their predicted interval.

To add a set-up: its file in config/validation, its name in the column `setup` of config/data/measured.tsv, and
`make reference`. Figure, tables, verdicts and the page of the report follow from these.
"""
