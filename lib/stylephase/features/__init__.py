"""Vectors that the networks read and write, by name ([M22] 3.2)."""
