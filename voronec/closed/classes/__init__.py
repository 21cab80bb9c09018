"""Classes of traces, exactly; motions of a class; the classes of very many motions at once."""

from voronec.closed.classes.search import find
from voronec.closed.classes.survey import Survey, classify_many, survey
from voronec.closed.classes.trace_classes import LABELS, TraceClass, classify

__all__ = ["LABELS", "Survey", "TraceClass", "classify", "classify_many", "find", "survey"]
