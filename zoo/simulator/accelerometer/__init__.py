"""A quartz vibrating-beam accelerometer at power-on, and the levelling that three of them do."""
