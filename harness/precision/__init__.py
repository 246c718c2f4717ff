"""What a frequency costs, and what an element buys."""
