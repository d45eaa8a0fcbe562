"""A survey of one's own: check, calibrate, look, keep.

The survey is simulated here, so that this runs anywhere; `read_survey("survey.toml")` reads yours.
"""

# %%
import pathlib

import numpy as np

import boresight as bs

bs.simulate(bs.demo("pool"), "survey", seed=7)
survey = bs.read_survey("survey/survey.toml")  # InputError lists every fault of every file at once
print(bs.check(survey))

# %%
result = bs.calibrate(survey, progress=bs.bar())  # Ctrl-C works
assert result.usable, result.reason
assert result.sigma is not None
print()
print("sigma of the angles, deg:", np.degrees(result.sigma[:3]).round(4))
print("sigma of the lever arm, mm:", (1e3 * result.sigma[3:6]).round(2))

# %% how far the soundings on the target lie from where the nominal mounting put them
moved_m = np.linalg.norm(bs.georeference(survey, result) - bs.georeference(survey), axis=1)
print(f"the calibration moves soundings by {np.nanmedian(moved_m):.2f} m in the median")

# %%
result.report("report.html")
result.write("result", exports=["sis"])
print(sorted(p.name for p in pathlib.Path("result").iterdir()))
