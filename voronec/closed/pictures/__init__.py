"""Pictures of motions in closed form, and the style of all figures."""
