"""What is built from the package: pages, pictures, the site, stored derivations."""
