"""DEM contact parameters for seeds and grains, from what you film at the bench."""
