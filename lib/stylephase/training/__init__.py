"""Sampling, losses, the loop, and one preset per experiment."""
