"""Swarm searches as pure ask/tell on a tuple of tensors; they know nothing of gyros, nets or Lightning."""
