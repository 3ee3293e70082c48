"""How conclusions depend on the settings: designs, gains, importance and robustness over many variants."""
