"""Every checkable statement of the paper, measured and judged."""
