"""An effect that the model does not have: how much of it is in the data, and what it does to the mounting.

A boat squats with the square of its speed. The survey is the simulator's; the squat is put into it here, so that the answer is known.
"""

# %%
import numpy as np

import boresight as bs

given = bs.simulate(bs.demo("pool")).survey
t, beams = given.trajectory, given.soundings

# %% speed over ground at every sounding, from the trajectory's positions
EARTH_M = 6_371_000.0
north = EARTH_M * np.gradient(t.latitude_rad, t.time_s)
east = EARTH_M * np.cos(t.latitude_rad) * np.gradient(t.longitude_rad, t.time_s)
smooth = np.ones(51) / 51
speed = np.hypot(np.convolve(north, smooth, "same"), np.convolve(east, smooth, "same"))
speed = np.interp(beams.time_s, t.time_s, speed)
print(f"speed {speed.min():.2f} to {speed.max():.2f} m/s")

# %% a slow clock in the sounder lengthens its ranges from the first pass to the last: 4 cm in all
since = (beams.time_s - beams.time_s[0]) / np.ptp(beams.time_s)
ranges = beams.range_m - 0.04 * since
soundings = bs.Soundings(
    beams.time_s, beams.across_rad, beams.along_rad, range_m=ranges, ping=beams.ping, beam=beams.beam, noise=beams.noise
)
survey = bs.Survey(
    t, given.laser, soundings, given.target, given.pose, scanner=given.scanner, sonar=given.sonar, config={"joint": given.config["joint"]}
)

# %% as it is
print(bs.calibrate(survey).findings[:1])

# %% with two unknowns: the clock, and a squat that is not there
clock = bs.Extra("clock", since, unit="m", acts_on="range")
squat = bs.Extra("squat", -(speed**2), unit="s2/m", prior_sigma=0.05)
result = bs.calibrate(survey, extra=[clock, squat]).require()
for p in result.extra.values():
    print(f"{p.name:6} {p.value:8.4f} +- {p.sigma:.4f} {p.unit}")
