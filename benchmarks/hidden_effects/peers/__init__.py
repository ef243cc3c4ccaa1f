"""Other methods on the same runs: PySINDy, a stepwise regression, the plain BIC ranking. Each names a set; none says that it knows none."""
