"""A pool calibration from arrays, without any file.

The arrays come from the simulator here, so that the answer is known; yours come from wherever your data are.
"""

# %%
import boresight as bs

given = bs.simulate(bs.demo("pool")).survey
t, laser, beams = given.trajectory, given.laser, given.soundings

# %% nothing but columns of numbers
survey = bs.Survey(
    bs.Trajectory(t.time_s, t.latitude_rad, t.longitude_rad, t.height_m, t.roll_rad, t.pitch_rad, t.heading_rad),
    bs.LaserScan(laser.time_s, laser.xyz_m, frame="sensor"),
    bs.Soundings(beams.time_s, beams.across_rad, range_m=beams.range_m),
    given.target,
    bs.Pose(given.pose.latitude_deg, given.pose.longitude_deg, given.pose.height_m, given.pose.azimuth_deg),
    scanner=given.scanner,
    sonar=bs.Mounting(roll_deg=-45, lever_arm_m=(0.5, -0.2, -1.6)),
)

# %%
result = bs.calibrate(survey).require()
for p in result.parameters.values():
    print(f"{p.name:6} {p.nominal:10.4f} {p.value:10.4f} +- {p.sigma:.4f} {p.unit}")

# %% the soundings in the target frame, the first of each ping
print(bs.georeference(survey, result)[survey.soundings.beam == 0][:3].round(3))
