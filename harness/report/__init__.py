"""The dashboard: one offline page, a section a file, each with its own template."""
