"""Diagnosis: where recordings depart from their baseline, and which physics, camera or reader's fault was left out.

    problem = drop.problem.problem_of(…)              # each rig: its noise, nuisances, candidates; 0 is the baseline
    base = fit(problem)                               # problem.py: everything later is asked of its reduced space
    where = locate(base, windows_of(base), rng)       # sector, window, axis
    found = name(base, where, rng)                    # none | name | class | unknown
    finding = finding_of(base, where, found)          # parameters, held-out figures: an entry of diagnosis.json

A rig is a folder (drop/, …) that makes a problem, most simply by series.py; an effect is a file in effects/<rig>/.
"""
