"""Controllers of a deployment: their laws, one file each, sensors and actuators, and the choice of gains."""
