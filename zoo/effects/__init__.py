"""What the gyro's error is made of: one small file an effect."""
