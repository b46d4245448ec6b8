"""Many simulated runs: into a store where each is computed once, out of it as a table.

from twin.campaign import run_campaign
from twin.job import Job

jobs = [Job("drop", Parameters(restitution=e), rng=(1, k), rendered=False) for e in
(0.45, 0.55) for k in range(10)] table = run_campaign(jobs, "study").table  # a row a
job, in their order; run again, it goes on where it was stopped

A script that runs this guards it by `if __name__ == "__main__":`, because the workers
are processes that import it."""

from twin.campaign.progress import Progress
from twin.campaign.results import Measured, Measurement, Outcome, Results
from twin.campaign.run import read_campaign, run_campaign, stream_campaign
from twin.campaign.store import CampaignStopped

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
