"""Networks, built from few parts ([M22] 4.1 to 4.3)."""
