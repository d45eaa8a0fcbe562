"""What does INS drift cost, by either path? A sweep to a table and a picture."""

# %%
import numpy as np

import boresight as bs

scenario = bs.demo("usbl").replace("per_beacon = 200", "per_beacon = 40")  # thinned, to be quick
campaign = bs.Campaign(scenario, 25, vary={"attitude.heading_sigma_deg": [0.05, 0.1, 0.2, 0.4]})
trials = campaign.run("heading", progress=bs.bar())  # run again = go on

# %% the errors as a grid: sigma of the heading, seed, path, parameter
grid = trials.to_xarray()
rms = (180 / np.pi) * ((grid["error"] ** 2).mean("seed") ** 0.5).sel(parameter="yaw")
print()
print(rms.to_pandas().round(4))

# %% are the reported sigmas right? 1 where they are
pulls = (grid["error"].sel(path="joint") / grid["variance"] ** 0.5).std("seed")
print(pulls.to_pandas().round(2))

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture without boresight[plot]")
else:
    rms.plot.line(x="attitude.heading_sigma_deg", hue="path", xscale="log", yscale="log")
    plt.ylabel("RMS error of yaw, deg")
    plt.savefig("heading.png")
