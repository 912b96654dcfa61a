"""Random draws of contacts: random words by counter, tables of quantiles, contacts that form."""
