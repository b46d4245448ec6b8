"""Diagnosis: where a recording departs from its baseline, and which physics or camera fault was left out.

    session = assemble(read_drops(folder))            # calibrate.twin.tracks, drop.session: recordings of one session
    base = fit(build(session))                        # drop.model, drop.baseline: noise, nuisances, every impact free
    where = locate(base, rng)                         # sector, window, axis
    found = name(base, where, rng)                    # none | name | class | unknown

The drop only, and of it what acts in flight and in the picture: impacts are free in the baseline, so laws of restitution, films
and tilted plates neither disturb a verdict nor get one.
"""
