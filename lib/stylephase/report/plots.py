"""The visual language of all plots, and the plots that more than one notebook needs."""

STYLE = {"font.family": "DejaVu Sans"}
