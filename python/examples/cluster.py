"""A campaign on a Dask cluster: two processes of this machine here, `dask_jobqueue.SLURMCluster` on a real one."""

# %%
from distributed import Client, LocalCluster

import boresight as bs


def main() -> None:
    scenario = bs.demo("usbl").replace("per_beacon = 200", "per_beacon = 40")  # thinned, to be quick
    campaign = bs.Campaign(scenario, 30, single=3)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        trials = campaign.run("big", client=client, chunk=10)
    print(trials)
    campaign.run("big")  # the rest on this machine, where any is left: the same bytes
    found = campaign.summary("big", out="report")
    joint = next(path for path in found["paths"] if path["path"] == "joint")
    for share in joint["shares"]:
        print(share["source"], share["standard_deviation"])


if __name__ == "__main__":  # processes that are spawned import this file
    main()
