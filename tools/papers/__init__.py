"""A paper under its audit: errors put in, premises changed, the transcription compared."""
