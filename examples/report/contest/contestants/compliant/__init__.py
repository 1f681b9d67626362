"""The contestants for stops that give way, in the form of those for rigid ones: a package without a file here is none."""
