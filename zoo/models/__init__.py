"""The zoo: bare modules without training code, scriptable."""
