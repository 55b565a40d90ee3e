"""What fit-actuator adds: rate polynomials, stiffness, transition zone, verdict."""
