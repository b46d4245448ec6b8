"""What kernels see of a state and its world: arrays all (see `state.State` for those
that outlive a call)."""

from collections import namedtuple

View = namedtuple(
    "View",
    "motion body turn spin load calm trait shape_of material ball owner path ball_start"
    " shape shape_start shape_ball pair_i pair_j pair_memory pair_touch pair_quiet"
    " awake awakes sleeps woken wall_i wall_p wall_memory wall_touch block_body"
    " block_pair block_wall block_window window sums totals prim prim_rest prim_ref"
    " prim_kind prim_wall wall_material corners twist wall_push wall_load moves"
    " move_numbers wall_way table materials gravity body_numbers shared single pull"
    " whole",
)
