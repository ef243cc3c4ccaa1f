"""How the models of the zoo are fitted."""
