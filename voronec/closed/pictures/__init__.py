"""Pictures of motions in closed form."""
