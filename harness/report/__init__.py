"""The page: one offline file, made of the results of one run; a section a file."""
