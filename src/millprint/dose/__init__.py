"""What a chemist reads off a mill: energy spectra, dose, heat and wear, from run.h5 and summaries."""
