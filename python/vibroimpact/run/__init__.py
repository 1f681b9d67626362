"""How work is run: in pieces on workers, tile by tile, and kept in stores that are gone on with."""
