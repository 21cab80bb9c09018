"""What the names of the paper stand for, section by section, in derived systems."""
