"""Which gyros there are: what a class is, the classes, the gyros of papers, and one gyro drawn from its class."""
