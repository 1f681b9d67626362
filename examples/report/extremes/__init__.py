"""Extreme and stiff cases: the rows that must hold, and a file for each family of cases that try them."""
