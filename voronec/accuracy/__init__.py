"""Speed against error, and numerically hard cases."""
