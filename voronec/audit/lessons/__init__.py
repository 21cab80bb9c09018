"""For teaching: equations judged, one problem by all methods, derivations step by step."""
