"""Classes of traces, exactly; motions of a class; the classes of very many motions at once."""
