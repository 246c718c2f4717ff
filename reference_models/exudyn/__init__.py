"""The mechanism in Exudyn: beams, cables and reduced solids between ideal joints."""
