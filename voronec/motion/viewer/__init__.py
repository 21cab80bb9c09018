"""A motion as one page that needs no network: bodies in space, sliders, curves of integrals."""
