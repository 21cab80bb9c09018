"""Pictures of trajectories, models, sections and rolling bodies."""
