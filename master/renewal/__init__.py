"""Number conservation, written with survivals, solved panel by panel."""
