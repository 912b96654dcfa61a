"""Laws of breaking with thresholds that diffuse (ageing) or grow (grains, strengthening)."""
