"""Reports for readers: tables, LaTeX, pages."""
