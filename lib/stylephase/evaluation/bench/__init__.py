"""The performance table: every figure beside its reference, measured in the same run."""
