"""Fitting that knows no gyros: variable projection, bounds, standard errors.

A room of its own below effects and models, since training and diagnosis both fit and siblings don't import each other.
"""
