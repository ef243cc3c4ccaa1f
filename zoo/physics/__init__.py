"""Heat and time: lags, recurrences, heat networks. SI and float64, differentiable."""
