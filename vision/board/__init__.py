"""A printed board in a picture → scale, distance and attitude of the camera."""
