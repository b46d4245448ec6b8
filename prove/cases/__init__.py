"""Recording recordings whose truth is known: one file a rig, and what they share (the
flying ellipsoid, camera, noise, pictures)."""
