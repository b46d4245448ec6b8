"""The discrete element engine: a frozen `World`, a `State`, and `init`, `step`, `run`
between them."""
