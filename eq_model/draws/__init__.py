"""What contacts draw: random words by counter, quantiles as tables, contacts that form."""
