"""A calibration's parameters on a system that they were not calibrated on.

posterior    what a calibration's folder keeps of it                 posterior.py
predict      runs at drawn parameters, intervals                     predict.py
beside       recordings of that system, and whether they agree       beside.py
picture      both as an SVG                                          picture.py
"""
