"""From pixels to metres: camera, lens, scale, plumb line, rigid body."""
