"""What a powder has been through in a mill, from run.h5 and the summaries of runs alone: wear of the balls."""
