"""Numbers that judge: bias stability and RMS by stage, noise floor, residual tests."""
