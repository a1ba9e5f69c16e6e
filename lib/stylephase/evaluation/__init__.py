"""Test errors, naive predictors, and metrics of generated motion."""
