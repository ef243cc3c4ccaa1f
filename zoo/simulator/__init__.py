"""Simulated gyros: chamber programs, heat, effects, thermometers and noise make measurement files with the truth beside them."""
