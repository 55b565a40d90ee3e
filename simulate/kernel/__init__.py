"""The compiled six-leg platform: memory layout, mechanics, integration, step size."""
