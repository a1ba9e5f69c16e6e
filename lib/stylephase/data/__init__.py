"""Where motion comes from: registry, archives, and the catalogue of clips."""
