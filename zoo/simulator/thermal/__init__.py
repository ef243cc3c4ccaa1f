"""Heat in a packaged gyro, what its winding makes of it, and where constant coefficients bite."""
