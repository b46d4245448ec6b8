"""Rolling friction means nothing without its convention.

Engines write the braking torque as μ_r F_n times a length, and take different lengths:
each sphere's own radius R, or the effective radius R* = R₁R₂/(R₁+R₂), which is R/2
between equal spheres and R at a wall. The same torque then needs another μ_r."""

import plotly.graph_objects as go

from benchtwin.calibrate.export.conventions import rolling_friction

calibrated = 0.04  # seed on seed, EDEM's standard convention
lengths = {"own": "R (EDEM)", "effective": "R* (LAMMPS)", "mean": "R̄ (YADE)"}
seed_seed = {
    length: rolling_friction(calibrated, "edem", length, on_wall=False)
    for length in lengths
}
seed_wall = {
    length: rolling_friction(calibrated, "edem", length, on_wall=True)
    for length in ("own", "effective")
}
for length, name in lengths.items():
    print(f"{name}: {seed_seed[length]:.3f} between seeds")
torque_shares = {"own": 1.0, "effective": 0.5, "mean": 1.0}  # of R, equal spheres

picture = go.Figure(go.Bar(x=list(lengths.values()), y=list(seed_seed.values())))
picture.update_yaxes(title="μ_r for the same torque between equal spheres")
