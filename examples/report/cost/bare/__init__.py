"""Builds of the crate from which parts are taken out at their source, to count what the parts cost where they are not used."""
