"""Heat and time: lags, recurrences, heat conduction, windings. SI and float64, differentiable."""
