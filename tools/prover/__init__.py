"""The attack on the prover: statements of known truth, asked for verdicts."""
