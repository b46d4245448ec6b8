"""Each rig's recordings, stated as one problem for the engine."""
