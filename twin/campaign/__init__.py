"""Many simulated runs: into a store where each is computed once, out of it as a table.

from benchtwin.twin.campaign import run_campaign
from benchtwin.twin.job import Job

jobs = [Job(rig, Parameters(restitution=e), rng=(1, k), rendered=False) for e in
(0.45, 0.55) for k in range(10)] table = run_campaign(jobs, "study").table  # a row a
job, in their order; run again, it goes on where it was stopped

A script that runs this guards it by `if __name__ == "__main__":`, because the workers
are processes that import it."""

from benchtwin.twin.campaign.progress import Progress
from benchtwin.twin.campaign.results import Measured, Measurement, Outcome, Results
from benchtwin.twin.campaign.run import read_campaign, run_campaign, stream_campaign
from benchtwin.twin.campaign.store import CampaignStopped

__all__ = [
    "CampaignStopped",
    "Measured",
    "Measurement",
    "Outcome",
    "Progress",
    "Results",
    "read_campaign",
    "run_campaign",
    "stream_campaign",
]
