"""The running text of the paper, sentence by sentence: quoted, with what decides each."""
