"""Runs models at cases, compares them, keeps and shows what they say."""
