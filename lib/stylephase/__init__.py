"""Style modelling of human walking, replicated: Mason et al. 2018 ([M18]) and 2022 ([M22])."""

__version__ = "0.1.0"
