"""Any poses by any models: on all cores or a cluster, resumable."""
