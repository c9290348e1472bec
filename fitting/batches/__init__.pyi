"""Many photographs: jobs for worker processes, a file of rows that survives kills, a summary and a control chart."""

from fitting.batches.cluster_pool import ClusterPool as ClusterPool
from fitting.batches.coordinator import Tally as Tally
from fitting.batches.coordinator import run as run
from fitting.batches.job import FAILED as FAILED
from fitting.batches.job import Job as Job
from fitting.batches.job import described as described
from fitting.batches.job import digest_of as digest_of
from fitting.batches.ledger import Ledger as Ledger
from fitting.batches.local_pool import LocalPool as LocalPool
from fitting.batches.sources import follow as follow
from fitting.batches.sources import photographs as photographs
from fitting.batches.summary import Batch as Batch
from fitting.batches.summary import rows_of as rows_of
