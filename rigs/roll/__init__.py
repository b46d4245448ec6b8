"""A seed that rolls down an incline and out on the level."""
