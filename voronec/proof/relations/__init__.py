"""How systems validate one another: relations of their motions, proved, and the diagram of them."""
