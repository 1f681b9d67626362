"""What the reports share: pages with their provenance, interleaved timing, scenes, references and contestants."""
