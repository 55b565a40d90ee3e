"""The gap between model and measurement: size, place, and the force it stands for."""
