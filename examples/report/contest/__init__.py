"""Error against run time: problems, their references, contestants, trials, the front."""
