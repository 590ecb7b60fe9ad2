"""Forces and couples of the moving parts on the body, per order of the crank speed."""
