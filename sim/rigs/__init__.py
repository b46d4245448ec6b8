"""The rigs of the bench: geometry, filling, moving, and when it is over. Each file
gives a frozen description, its defaults those of the soybean paper, and one function
that runs it: `(rig, bench, rng, fps, watch) -> Motion`."""
