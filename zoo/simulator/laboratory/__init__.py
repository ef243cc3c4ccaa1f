"""Where the gyro is tested: chamber programs, the air that follows them, rate tables, the turning Earth."""
