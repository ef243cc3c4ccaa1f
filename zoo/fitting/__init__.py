"""Fitting grey boxes to runs: variable projection, bounds, standard errors, the noise that residuals are weighed against.

A room between models and training, for training and diagnosis both fit and siblings don't import each other.
"""
