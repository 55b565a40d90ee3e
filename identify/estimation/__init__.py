"""Parameters, residuals, least squares and uncertainty, for loops and deployments alike."""
