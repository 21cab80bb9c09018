"""What scripts share: the choice of a kind, and the clock of a child."""
