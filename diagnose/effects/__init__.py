"""What may be missing from the simulation: a folder a rig, an effect a file."""
