"""The conformance suite: every claim a scheme makes, and every property all schemes owe, as checks with a witness."""
