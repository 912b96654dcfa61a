"""How contacts break: at thresholds that stay, at a rate, and at those that diffuse or grow."""
