"""Figures, skeleton pictures, claims with verdicts, and the notebook runner."""
