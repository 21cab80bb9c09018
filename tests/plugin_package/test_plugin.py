from voronec.testing import conformance

test_conformance = conformance("plugin-hoop")
