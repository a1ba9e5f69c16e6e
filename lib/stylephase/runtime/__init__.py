"""From a trained network to a moving character ([M22] 4.4)."""
