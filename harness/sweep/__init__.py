"""Any poses by any models: on all cores or a cluster, resumable."""

from harness.sweep.pose_sets import pose_set
from harness.sweep.sweep import Swept, solve

__all__ = ["Swept", "pose_set", "solve"]
