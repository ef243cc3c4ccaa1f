"""The page beside a simulation: the winding, the heat in it, and the bias by effect."""
