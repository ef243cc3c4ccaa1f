"""How far a model is from measurements, where it fails, which effect is missing."""
