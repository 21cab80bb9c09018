"""Classes of traces, exactly; motions of a class; the classes of very many motions at once."""

from voronec.closed.classes.finding import find
from voronec.closed.classes.labels import LABELS, TraceClass, classify
from voronec.closed.classes.many import classify_many
from voronec.closed.classes.survey import Survey, survey

__all__ = ["LABELS", "Survey", "TraceClass", "classify", "classify_many", "find", "survey"]
