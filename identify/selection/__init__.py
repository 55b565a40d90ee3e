"""Which effect is missing: screening, model comparison, verdict, detection limits."""
