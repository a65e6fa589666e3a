"""Hypotheses judged on the linear model: effects, pairs, what is ordinary, what looks alike."""
