"""What the systems of this folder share: an underscore, so no system itself."""

import sympy as sp

m, R = sp.symbols("m R")
